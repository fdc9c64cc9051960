//! Numbers as they stand in a drawing: short, with a true minus sign.

/// A number with at most four significant digits.
pub(crate) fn number(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let magnitude = value.abs();
    let text = if (1e-3..1e5).contains(&magnitude) {
        let digits = 3 - libm::log10(magnitude).floor() as i32;
        let decimals = usize::try_from(digits).unwrap_or(0);
        let text = format!("{value:.decimals$}");
        if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            text
        }
    } else {
        let text = format!("{value:.3e}");
        match text.split_once('e') {
            Some((mantissa, exponent)) => {
                let mantissa = mantissa.trim_end_matches('0').trim_end_matches('.');
                format!("{mantissa}e{exponent}")
            }
            None => text,
        }
    };
    text.replace('-', "−")
}

/// A coefficient beside an input; none where it is 1.
pub(super) fn coefficient(value: f64) -> Option<String> {
    (value != 1.0).then(|| number(value))
}

#[cfg(test)]
mod tests {
    use super::number;

    #[test]
    fn numbers_are_short() {
        for (value, text) in [
            (0.0, "0"),
            (1.0, "1"),
            (-0.2, "−0.2"),
            (8.0 / 3.0, "2.667"),
            (10000.0, "10000"),
            (1234567.0, "1.235e6"),
            (-1e-4, "−1e−4"),
            (100.0, "100"),
            (0.005, "0.005"),
        ] {
            assert_eq!(number(value), text);
        }
    }
}
