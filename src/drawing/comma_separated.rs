//! Comma-separated values as in RFC 4180: records of fields, quoted where they hold commas, quotes or line breaks.

/// A field, quoted if it must be.
pub fn field(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_string() }
}

/// Fields of a record, and the number of the line it starts on.
pub type Record = (usize, Vec<String>);

/// The records of a text, each with the number of the line it starts on; empty lines are skipped.
///
/// # Errors
/// The line and its defect.
pub fn records(text: &str) -> Result<Vec<Record>, (usize, String)> {
    let (mut records, mut fields, mut current) = (Vec::new(), Vec::new(), String::new());
    let (mut line, mut first_line, mut quoted, mut was_quoted) = (1, 1, false, false);
    let mut letters = text.chars().peekable();
    while let Some(letter) = letters.next() {
        match letter {
            '"' if quoted && letters.peek() == Some(&'"') => {
                letters.next();
                current.push('"');
            }
            '"' if quoted => quoted = false,
            '"' if current.is_empty() && !was_quoted => (quoted, was_quoted) = (true, true),
            '"' => return Err((line, "a quote in the middle of a field".to_string())),
            ',' if !quoted => {
                fields.push(std::mem::take(&mut current));
                was_quoted = false;
            }
            '\n' if !quoted => {
                line += 1;
                if !(fields.is_empty() && current.trim().is_empty() && !was_quoted) {
                    fields.push(std::mem::take(&mut current));
                    records.push((first_line, std::mem::take(&mut fields)));
                }
                current.clear();
                (first_line, was_quoted) = (line, false);
            }
            '\r' if !quoted && letters.peek() == Some(&'\n') => {}
            letter => {
                line += usize::from(letter == '\n');
                current.push(letter);
            }
        }
    }
    if quoted {
        return Err((first_line, "a quote is not closed".to_string()));
    }
    if !(fields.is_empty() && current.trim().is_empty()) {
        fields.push(current);
        records.push((first_line, fields));
    }
    Ok(records)
}
