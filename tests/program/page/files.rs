//! A page is one file, the same for the same log, and there or not.

use super::{done, header, with_log};
use crate::common::command::{assert_one_error, run, text};

#[test]
fn a_page_loads_nothing_and_its_parts_are_whole() {
    let folder = with_log("alone");
    assert_eq!(done(&folder, &["report", "red.mcap"]), "red.html: 2 s of red.mcap\n");
    done(&folder, &["model", "red.urdf", "-o", "model.html"]);
    for name in ["red.html", "model.html"] {
        let page = std::fs::read_to_string(folder.join(name)).expect("a page");
        for loading in [" src=", "<link", "@import", "url(http", "{{"] {
            assert!(!page.contains(loading), "{name} has {loading}");
        }
        assert_eq!(page.matches("</script>").count(), page.matches("<script").count(), "{name}");
        // The libraries have 620 kB; the rest is this small model.
        assert!(page.len() < 750_000, "{name}: {} bytes", page.len());
    }
}

#[test]
fn the_same_log_gives_the_same_page_and_simulate_writes_that_page_too() {
    let folder = with_log("same");
    done(&folder, &["report", "red.mcap", "-o", "one.html", "--quiet"]);
    done(&folder, &["report", "red.mcap", "-o", "two.html"]);
    let read = |name: &str| std::fs::read(folder.join(name)).expect("a page");
    assert!(read("one.html") == read("two.html"));
    let said = done(&folder, &["simulate", "red.urdf", "--duration", "1", "--report", "both.html"]);
    assert!(said.ends_with("  page        both.html\n"), "{said}");
    done(&folder, &["report", "red.mcap", "-o", "after.html"]);
    assert!(read("both.html") == read("after.html"));
}

#[test]
fn names_that_look_like_markup_are_words_in_a_page() {
    let folder = with_log("markup");
    let evil = super::RED.replace("\"rod\"", "\"&lt;/script>&lt;b>\"").replace("name=\"red\"", "name=\"&lt;!--&amp;\"");
    std::fs::write(folder.join("evil.urdf"), evil).expect("written");
    done(&folder, &["model", "evil.urdf", "-o", "evil.html"]);
    let page = std::fs::read_to_string(folder.join("evil.html")).expect("a page");
    assert!(!page.contains("</script><b>") && !page.contains("<!--&"));
    assert_eq!(header(&page)["tree"]["links"][1]["name"], "</script><b>");
}

#[test]
fn a_log_that_was_cut_gives_the_page_of_what_is_left_or_an_error_and_no_page() {
    let folder = with_log("cut");
    let whole = std::fs::read(folder.join("red.mcap")).expect("a log");
    let page = folder.join("cut.html");
    let mut shown = 0;
    for part in 0..12 {
        std::fs::write(folder.join("cut.mcap"), &whole[..whole.len() * part / 12]).expect("written");
        let _ = std::fs::remove_file(&page);
        let output = run(&folder, &["report", "cut.mcap"]);
        if output.status.code() == Some(0) {
            shown += 1;
            assert!(text(&output.stderr).contains("TRUNCATED"), "{}", text(&output.stderr));
            let header = header(&std::fs::read_to_string(&page).expect("a page"));
            assert!(header["facts"][0][1].as_str().is_some_and(|state| state.contains("TRUNCATED")), "{header}");
        } else {
            let error = text(&output.stderr).lines().last().unwrap_or_default().to_string();
            assert_eq!(output.status.code(), Some(2), "{error}");
            assert!(error.starts_with("catena: error: "), "{error}");
            assert!(!page.exists(), "part {part}");
        }
    }
    // The samples are most of the log.
    assert!(shown >= 3, "{shown}");
}

#[test]
fn what_is_no_log_and_what_must_not_be_replaced_are_refused() {
    let folder = with_log("refused");
    assert_one_error(&run(&folder, &["report", "red.urdf", "-o", "page.html"]), 2, "no log");
    assert_one_error(&run(&folder, &["report", "absent.mcap"]), 2, "absent");
    assert_one_error(&run(&folder, &["report", "red.mcap", "-o", "red.mcap"]), 2, "the log");
    assert_one_error(&run(&folder, &["report", "red.mcap", "-o", "nowhere/page.html"]), 2, "no folder");
    assert_one_error(&run(&folder, &["model", "red.urdf", "-o", "red.urdf"]), 2, "the model");
    for page in ["red.urdf", "red.mcap", "nowhere/page.html"] {
        assert_one_error(&run(&folder, &["simulate", "red.urdf", "--report", page]), 2, page);
    }
    assert_one_error(&run(&folder, &["simulate", "red.urdf", "--no-log", "--report", "page.html"]), 2, "no log");
    assert_eq!(std::fs::read_to_string(folder.join("red.urdf")).expect("still there"), super::RED);
    assert!(!folder.join("page.html").exists());
}
