//! Plain words: how often comments and documents use five mannerisms that leave out the noun or hide the subject.
//!
//! A sentence is a stretch of more than 60 characters of a paragraph, up to a full stop, colon or semicolon before a capital letter. Code spans count as
//! one letter; code blocks, tables and headings are passed over. With `h` sentences that have a mannerism among `n`, its rate is
//!
//! ```text
//!     r = 100 h / n        [sentences in a hundred],    at most 1 for each mannerism
//! ```
//!
//! CONTRIBUTING.md has the rules, and what to write instead.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Sentences in a hundred that may have a mannerism: the rate of the plainest of the code bases that were compared is between 0 and 1.2.
const MOST: f64 = 1.0;

/// Shorter pieces of text are no sentences (characters).
const SHORTEST: usize = 60;

/// Worst places that a failure lists.
const LISTED: usize = 40;

/// The words that make "what …" a noun.
const AFTER_WHAT: &str = "is are was were has have had does do did it they move moves hold holds act acts other others nothing comes follows lies \
     touches falls stays remains changes can must may would will needs stands slides sticks presses";

/// A word of a sentence, with the characters between it and the word before.
struct Word<'s> {
    gap: &'s str,
    text: &'s str,
}

/// A habit that makes sentences hard to read.
struct Mannerism {
    name: &'static str,
    is_in: fn(&[Word]) -> bool,
}

/// The folder of the repository.
const ROOT: &str = env!("CARGO_MANIFEST_DIR");

const MANNERISMS: [Mannerism; 5] = [
    Mannerism {
        name: "\"what …\" as a noun",
        is_in: |words| {
            pairs(words).any(|(what, verb)| {
                let begins =
                    what.gap.chars().next_back().is_none_or(|last| last.is_whitespace() || ",;:(".contains(last));
                begins && is_one_of(what, "what") && is_one_of(verb, AFTER_WHAT)
            })
        },
    },
    Mannerism {
        name: "nothing, none, nobody, nowhere",
        is_in: |words| words.iter().any(|word| is_one_of(word, "nothing none nobody nowhere")),
    },
    Mannerism {
        name: "those or that with of, which, with, in, where, whose, on",
        is_in: |words| {
            pairs(words)
                .any(|(noun, link)| is_one_of(noun, "those that") && is_one_of(link, "of which with in where whose on"))
        },
    },
    Mannerism {
        name: "so many, so long, so often, so much, so few",
        is_in: |words| {
            pairs(words).any(|(so, count)| is_one_of(so, "so") && is_one_of(count, "many long often much few"))
        },
    },
    Mannerism {
        name: "begins with Where, Of, What, Beyond, From, With, By",
        is_in: |words| {
            let first = words.first().filter(|word| word.gap.is_empty());
            first.is_some_and(|word| ["Where", "Of", "What", "Beyond", "From", "With", "By"].contains(&word.text))
        },
    },
];

fn is_one_of(word: &Word, list: &str) -> bool {
    list.split_whitespace().any(|one| one == word.text.to_lowercase())
}

/// Words that follow each other with one space between.
fn pairs<'w, 's>(words: &'w [Word<'s>]) -> impl Iterator<Item = (&'w Word<'s>, &'w Word<'s>)> {
    words.windows(2).filter(|pair| pair[1].gap == " ").map(|pair| (&pair[0], &pair[1]))
}

fn words(sentence: &str) -> Vec<Word<'_>> {
    let is_of_word = |c: char| c.is_alphanumeric() || c == '_';
    let (mut found, mut rest) = (Vec::new(), sentence);
    while let Some(start) = rest.find(is_of_word) {
        let length = rest[start..].find(|c| !is_of_word(c)).unwrap_or(rest.len() - start);
        found.push(Word { gap: &rest[..start], text: &rest[start..start + length] });
        rest = &rest[start + length..];
    }
    found
}

/// The text of a line that people read: of a comment, or of a document; `None` for a line of code.
fn prose<'l>(line: &'l str, kind: &str) -> Option<&'l str> {
    let marker = match kind {
        "rs" => "//",
        "py" => "#",
        _ => return Some(line),
    };
    let text = line.trim_start().strip_prefix(marker)?;
    let text = if kind == "rs" { text.strip_prefix(['/', '!']).unwrap_or(text) } else { text };
    Some(text.strip_prefix(' ').unwrap_or(text))
}

/// The paragraphs of a file, each with the number of its first line: comment lines or lines of a document without an empty one between, or an item of a
/// list.
fn paragraphs(text: &str, kind: &str) -> Vec<(usize, String)> {
    let mut found: Vec<(usize, String)> = Vec::new();
    let (mut continues, mut in_code) = (false, false);
    for (index, line) in text.lines().enumerate() {
        let Some(read) = prose(line, kind) else {
            (continues, in_code) = (false, false);
            continue;
        };
        let trimmed = read.trim();
        if trimmed.starts_with("```") {
            (continues, in_code) = (false, !in_code);
            continue;
        }
        if in_code || trimmed.is_empty() || trimmed.starts_with(['|', '#']) || read.starts_with("    ") {
            continues = false;
            continue;
        }
        match found.last_mut() {
            Some((_, paragraph)) if continues && !trimmed.starts_with(['-', '*']) => {
                paragraph.push(' ');
                paragraph.push_str(trimmed);
            }
            _ => found.push((index + 1, trimmed.trim_start_matches(['-', '*', ' ']).to_string())),
        }
        continues = true;
    }
    found
}

/// A text with one letter for each code span.
fn without_code(text: &str) -> String {
    let (mut plain, mut rest) = (String::new(), text);
    while let Some((before, after)) = rest.split_once('`') {
        let Some((_, beyond)) = after.split_once('`') else { break };
        plain.push_str(before);
        plain.push('x');
        rest = beyond;
    }
    plain + rest
}

/// The sentences of a paragraph that are long enough.
fn sentences(paragraph: &str) -> Vec<String> {
    let plain = without_code(paragraph);
    let (mut found, mut start) = (Vec::new(), 0);
    for (end, _) in plain.match_indices(['.', '!', '?', ':', ';']) {
        let rest = &plain[end + 1..];
        let next = rest.trim_start();
        if end >= start && next.len() < rest.len() && next.starts_with(|c: char| c.is_ascii_uppercase()) {
            found.push(plain[start..=end].to_string());
            start = plain.len() - next.len();
        }
    }
    found.push(plain[start..].to_string());
    found.retain(|sentence| sentence.chars().count() > SHORTEST);
    found
}

/// The counts of some files.
#[derive(Default)]
struct Count {
    sentences: usize,
    found: [usize; MANNERISMS.len()],
    /// The places, with the number of their mannerisms.
    places: Vec<(usize, String)>,
}

impl Count {
    fn of(files: &[PathBuf]) -> Self {
        let mut count = Count::default();
        for file in files {
            let text = std::fs::read_to_string(file).expect("a source or document");
            let kind = file.extension().and_then(|kind| kind.to_str()).unwrap_or_default();
            count.add(&file.strip_prefix(ROOT).unwrap_or(file).display().to_string(), &text, kind);
        }
        count
    }

    fn add(&mut self, name: &str, text: &str, kind: &str) {
        for (line, paragraph) in paragraphs(text, kind) {
            for sentence in sentences(&paragraph) {
                self.sentences += 1;
                let words = words(&sentence);
                let has = MANNERISMS.each_ref().map(|mannerism| (mannerism.is_in)(&words));
                self.found.iter_mut().zip(has).for_each(|(count, has)| *count += usize::from(has));
                let several = has.iter().filter(|has| **has).count();
                if several > 0 {
                    self.places.push((several, format!("{name}:{line}: {sentence}")));
                }
            }
        }
    }

    /// Sentences in a hundred, for each mannerism.
    fn rates(&self) -> [f64; MANNERISMS.len()] {
        self.found.map(|found| 100.0 * found as f64 / self.sentences.max(1) as f64)
    }

    /// Rates and worst places in lines; empty if no rate is too large.
    fn complaint(mut self) -> String {
        let rates = self.rates();
        if rates.iter().all(|rate| *rate <= MOST) {
            return String::new();
        }
        let mut text = format!("{} sentences; in a hundred, at most {MOST} wanted:\n", self.sentences);
        for (mannerism, rate) in MANNERISMS.iter().zip(rates) {
            let _ = writeln!(text, "{rate:6.1}  {}", mannerism.name);
        }
        self.places.sort_by_key(|(several, _)| std::cmp::Reverse(*several));
        self.places.iter().take(LISTED).for_each(|(_, place)| {
            let _ = writeln!(text, "{place}");
        });
        text
    }
}

/// All files of these kinds in a folder and its folders, in their order; or the one file.
fn files(path: &str, kinds: &[&str]) -> Vec<PathBuf> {
    let (mut found, mut waiting) = (Vec::new(), vec![Path::new(ROOT).join(path)]);
    while let Some(place) = waiting.pop() {
        if !place.is_dir() {
            if place.extension().is_some_and(|kind| kinds.iter().any(|one| kind == *one)) {
                found.push(place);
            }
            continue;
        }
        for entry in std::fs::read_dir(&place).expect("a folder of the repository").flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            // Builds and environments are no part of the repository.
            if !name.starts_with('.') && !["target", "build", "__pycache__"].contains(&name.as_str()) {
                waiting.push(entry.path());
            }
        }
    }
    found.sort();
    found
}

#[test]
fn each_mannerism_is_in_at_most_one_sentence_in_a_hundred_of_the_documents() {
    let mut documents = files("README.md", &["md"]);
    documents.extend(files("doc", &["md"]));
    let count = Count::of(&documents);
    assert!(count.sentences > 300, "the documents were found: {} sentences", count.sentences);
    let complaint = count.complaint();
    assert!(complaint.is_empty(), "README.md and doc: {complaint}");
    let complaint = Count::of(&files("python", &["rs", "py", "md"])).complaint();
    assert!(complaint.is_empty(), "python: {complaint}");
}

#[test]
fn each_mannerism_is_in_at_most_one_sentence_in_a_hundred_of_the_comments() {
    let count = Count::of(&files("src", &["rs"]));
    assert!(count.sentences > 3000, "the sources were found: {} sentences", count.sentences);
    let complaint = count.complaint();
    assert!(complaint.is_empty(), "src: {complaint}");
}

#[test]
fn mannerisms_are_counted_in_sentences_of_comments_and_documents_and_nowhere_else() {
    let counted = |kind: &str, text: &str| {
        let mut count = Count::default();
        count.add("text", text, kind);
        (count.sentences, count.found)
    };
    let long = "and this makes the sentence longer than sixty characters, as sentences are";
    // One sentence for each mannerism; each has it once.
    for (number, begin) in [
        "The rows (what moves) count",
        "It has none",
        "The gap is that of a rim",
        "It takes so many steps",
        "By this rule",
    ]
    .iter()
    .enumerate()
    {
        let mut expected = [0; MANNERISMS.len()];
        expected[number] = 1;
        assert_eq!(counted("rs", &format!("/// {begin} {long}.\nfn a() {{}}")), (1, expected), "{begin}");
        assert_eq!(counted("md", &format!("{begin}\n{long}.")), (1, expected), "{begin}");
        assert_eq!(counted("py", &format!("    # {begin} {long}.")), (1, expected), "{begin}");
        // Code, tables, headings, code spans and short sentences do not count.
        assert_eq!(counted("rs", &format!("let a = \"{begin} {long}\";")).0, 0);
        assert_eq!(
            counted(
                "md",
                &format!("| {begin} {long} |\n# {begin} {long}\n```\n{begin} {long}\n```\n    {begin} {long}")
            )
            .0,
            0
        );
        assert_eq!(counted("md", &format!("It says `{begin}` {long}.")), (1, [0; MANNERISMS.len()]), "{begin}");
        assert_eq!(counted("md", &format!("{begin}.")).0, 0);
    }
    // Words that only look alike.
    let plain = "Somewhat is nonetheless so-called: that ofen, thoseof, whatever it is, somewhere, and withstanding";
    assert_eq!(counted("md", &format!("{plain} {long}.")), (1, [0; MANNERISMS.len()]));
    // Two sentences of a comment of two lines, and an item of a list.
    let two = format!("// It is plain {long}. With this rule\n// it is not, {long}:\n// - None of it {long}");
    assert_eq!(counted("rs", &two), (3, [0, 1, 0, 0, 1]));
}
