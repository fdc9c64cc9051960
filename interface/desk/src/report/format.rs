//! Numbers as text: significant digits, and typography for pages.

/// `value` rounded to `digits` significant digits, plain between 1e-4 and 1e7 and with an exponent
/// outside; from 17 on as it is, counts without a point. ASCII, for terminals and files.
pub fn significant(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return value.to_string();
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    if digits >= 17 {
        return value.to_string();
    }
    let digits = digits.max(1);
    let scientific = format!("{value:.*e}", digits - 1);
    let Some((mantissa, exponent)) = scientific.split_once('e') else {
        return scientific;
    };
    // Rounding may have carried (9.99 -> 1.00e1), so the exponent is read from the text.
    match exponent.parse::<i32>() {
        Ok(exponent) if (-4..7).contains(&exponent) => {
            let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
            if decimals == 0 {
                // Digits left of the point beyond those asked for are rounded to zeros.
                let rounded: f64 = scientific.parse().unwrap_or(value);
                format!("{rounded:.0}")
            } else {
                format!("{value:.decimals$}")
            }
        }
        _ => format!("{mantissa}e{exponent}"),
    }
}

/// The same for a page: a true minus sign, `1.2 × 10⁻⁵` for `1.2e-5`, `–` for NaN.
pub fn typeset(value: f64, digits: usize) -> String {
    if value.is_nan() {
        return "–".to_owned();
    }
    if value.is_infinite() {
        return if value > 0.0 { "∞" } else { "−∞" }.to_owned();
    }
    let text = significant(value, digits);
    match text.split_once('e') {
        Some((mantissa, exponent)) => format!(
            "{} × 10{}",
            mantissa.replace('-', "−"),
            exponent.parse().map(superscript).unwrap_or_default()
        ),
        None => text.replace('-', "−"),
    }
}

/// An exponent in superscript digits.
pub fn superscript(exponent: i32) -> String {
    exponent
        .to_string()
        .chars()
        .map(|c| match c {
            '-' => '⁻',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            digit => char::from_u32('⁰' as u32 + digit.to_digit(10).unwrap_or(0)).unwrap_or(digit),
        })
        .collect()
}

/// A quantity and its unit, a thin no-break space between.
pub fn with_unit(value: f64, digits: usize, unit: &str) -> String {
    let number = typeset(value, digits);
    match unit {
        "" => number,
        "%" | "°" => format!("{number}{}{unit}", if unit == "%" { "\u{202f}" } else { "" }),
        _ => format!("{number}\u{202f}{unit}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_and_carries() {
        for (value, digits, text) in [
            (1053.27, 5, "1053.3"),
            (9.9996, 4, "10.00"),
            (0.000_123_45, 3, "0.000123"),
            (0.000_012_345, 3, "1.23e-5"),
            (94_871.0, 3, "94900"),
            (12_345_678.0, 3, "1.23e7"),
            (-0.5, 2, "-0.50"),
            (0.0, 4, "0"),
            (9_999_999.9, 3, "1.00e7"),
            (101.0, 17, "101"),
        ] {
            assert_eq!(significant(value, digits), text);
        }
        assert_eq!(typeset(-1.5e-12, 2), "−1.5 × 10⁻¹²");
        assert_eq!(typeset(f64::NAN, 2), "–");
        assert_eq!(with_unit(23.6, 3, "km"), "23.6\u{202f}km");
    }
}
