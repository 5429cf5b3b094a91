//! Formats numbers and nouns for messages.

/// Three significant digits.
pub fn rounded(value: f64) -> String {
    if !value.is_finite() || value == 0.0 {
        return value.to_string();
    }
    let digits_before_point = value.abs().log10().floor() as i32;
    match digits_before_point {
        -4..=5 => format!("{value:.*}", (2 - digits_before_point).max(0) as usize),
        _ => format!("{value:.2e}"),
    }
}

/// Six decimals, or six digits after the first for numbers beyond 10⁹; a value that rounds to zero has no sign.
pub fn decimals(value: f64) -> String {
    if value.abs() >= 1e9 {
        return format!("{value:.6e}");
    }
    let text = format!("{value:.6}");
    match text.strip_prefix('-') {
        Some("0.000000") => "0.000000".to_string(),
        _ => text,
    }
}

/// All digits, without a row of zeros before or after them.
pub fn short(value: f64) -> String {
    if value != 0.0 && !(1e-3..1e16).contains(&value.abs()) { format!("{value:e}") } else { value.to_string() }
}

/// A number and its noun.
pub fn counted(count: usize, one: &str, several: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { several })
}

#[cfg(test)]
mod tests {
    use super::counted;
    use super::decimals;
    use super::rounded;
    use super::short;

    #[test]
    fn numbers_for_people_have_three_digits_and_nouns_agree() {
        assert_eq!([833.33, 0.012345, 1e9].map(rounded), ["833", "0.0123", "1.00e9"]);
        assert_eq!(counted(1, "stage", "stages"), "1 stage");
        assert_eq!(counted(2, "moving body", "moving bodies"), "2 moving bodies");
    }

    #[test]
    fn no_number_for_people_has_a_row_of_zeros_or_is_minus_nothing() {
        assert_eq!(
            [-1e-17, -0.0, -0.5, 3.10630092664032e18].map(decimals),
            ["0.000000", "0.000000", "-0.500000", "3.106301e18"]
        );
        assert_eq!([7.9e-51, 0.25, 0.0, 1e300, -2.0].map(short), ["7.9e-51", "0.25", "0", "1e300", "-2"]);
    }
}
