//! Rows as Parquet say what rows as CSV say, and shards merged are the whole.

use super::{MIXED, files, folder, table};
use crate::common::command::{run, text};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use std::fs::File;

/// A sweep with every kind of column; a third of the masses is negative.
fn kinds() -> String {
    format!(
        "{MIXED}[[vary]]\nkey = \"tip.mass\"\nnormal = [0.5, 1.0]\n\
         [keep]\nend = [\"positions\", \"energy\"]\ncurves = [\"positions\"]\nrate = 10\nevents = \"list\"\n"
    )
}

fn made(folder: &std::path::Path, options: &[&str]) {
    let output = run(folder, &[&["sweep"], options].concat());
    assert_eq!(output.status.code(), Some(0), "{options:?}: {}", text(&output.stderr));
}

#[test]
fn the_cells_of_parquet_are_those_of_csv() {
    let folder = folder("sweep_parquet", &kinds());
    made(&folder, &["sweep.toml", "-o", "parquet"]);
    made(&folder, &["sweep.toml", "-o", "csv", "--format", "csv"]);
    let expected = table(&folder.join("csv"));
    let mut rows = expected.iter();
    let (mut failed, mut numbers) = (0, 0);
    for name in files(&folder.join("parquet")).into_keys() {
        let reader = SerializedFileReader::new(File::open(folder.join("parquet").join(name)).unwrap()).unwrap();
        for row in reader.get_row_iter(None).unwrap() {
            let expected = rows.next().expect("as many rows");
            for (name, field) in row.unwrap().get_column_iter() {
                let said = &expected[name];
                match field {
                    Field::Null => assert_eq!(said, "", "{name}"),
                    Field::Double(number) => {
                        assert_eq!(said.parse::<f64>(), Ok(*number), "{name}");
                        numbers += 1;
                    }
                    Field::Long(count) => assert_eq!(said.parse(), Ok(*count), "{name}"),
                    Field::Str(words) => {
                        assert_eq!(said, words, "{name}");
                        failed += usize::from(words == "failed");
                    }
                    Field::ListInternal(list) => {
                        let in_csv: Vec<serde_json::Value> = serde_json::from_str(said).unwrap();
                        assert_eq!(in_csv.len(), list.len(), "{name}");
                        for (field, in_csv) in list.elements().iter().zip(in_csv) {
                            let Field::Double(number) = field else { panic!("{name}: {field}") };
                            assert_eq!(in_csv.as_f64(), Some(*number), "{name}");
                        }
                    }
                    other => panic!("{name}: {other}"),
                }
            }
        }
    }
    assert!(rows.next().is_none());
    assert!(failed > 2 && numbers > 24 * 3, "{failed} {numbers}");
}

#[test]
fn shards_merged_are_the_whole_byte_for_byte() {
    let folder = folder("sweep_parquet_shards", &kinds());
    made(&folder, &["sweep.toml", "-o", "whole"]);
    for number in 1..=3 {
        made(&folder, &["sweep.toml", "-o", &format!("shard{number}"), "--shard", &format!("{number}/3")]);
    }
    made(&folder, &["-o", "merged", "--merge", "shard3", "shard1", "shard2"]);
    assert!(files(&folder.join("merged")) == files(&folder.join("whole")));
}
