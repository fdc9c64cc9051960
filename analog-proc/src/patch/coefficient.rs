//! Products as they are written in a patch: `-c1 * c2 * net`, `2 * wn`, `0.5`.
//!
//! A leading minus and factors joined by `*`; each factor a number or a name.
//! There is no other arithmetic: a sum is a list of inputs, a quotient is a
//! divider block, so that every operation of the patch is a block.

use std::ops::Range;

/// One factor and its place in the string.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Factor<'a> {
    pub(crate) value: FactorValue<'a>,
    pub(crate) range: Range<usize>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum FactorValue<'a> {
    Number(f64),
    Name(&'a str),
}

/// A product; at least one factor.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Product<'a> {
    pub(crate) negative: bool,
    pub(crate) factors: Vec<Factor<'a>>,
}

/// Why a product cannot be read, where, and what to write instead.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ProductError {
    pub(crate) range: Range<usize>,
    pub(crate) why: &'static str,
    pub(crate) help: &'static str,
}

const SHAPE: &str = "write a product such as `net`, `-2.5 * net` or `-k * wn * net`";

/// Reads a product.
pub(crate) fn parse(text: &str) -> Result<Product<'_>, ProductError> {
    let mut rest = Cursor { text, at: 0 };
    rest.skip_space();
    let negative = rest.take('-');
    let mut factors = Vec::new();
    loop {
        rest.skip_space();
        factors.push(rest.factor()?);
        rest.skip_space();
        if rest.at == text.len() {
            return Ok(Product { negative, factors });
        }
        if !rest.take('*') {
            return Err(rest.unexpected());
        }
    }
}

/// Whether a text can name a parameter, block, port or instance.
pub(crate) fn is_name(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        && text.len() <= 120
}

struct Cursor<'a> {
    text: &'a str,
    at: usize,
}

impl<'a> Cursor<'a> {
    fn peek(&self) -> Option<char> {
        self.text[self.at..].chars().next()
    }

    fn skip_space(&mut self) {
        while let Some(c) = self.peek().filter(|c| c.is_whitespace()) {
            self.at += c.len_utf8();
        }
    }

    fn take(&mut self, wanted: char) -> bool {
        let found = self.peek() == Some(wanted);
        if found {
            self.at += wanted.len_utf8();
        }
        found
    }

    fn take_while(&mut self, accept: impl Fn(char) -> bool) {
        while let Some(c) = self.peek().filter(|c| accept(*c)) {
            self.at += c.len_utf8();
        }
    }

    fn factor(&mut self) -> Result<Factor<'a>, ProductError> {
        let start = self.at;
        match self.peek() {
            Some(c) if c.is_ascii_digit() || c == '.' => {
                self.take_while(|c| c.is_ascii_digit() || c == '.' || c == '_');
                if matches!(self.peek(), Some('e' | 'E')) {
                    self.at += 1;
                    if matches!(self.peek(), Some('+' | '-')) {
                        self.at += 1;
                    }
                    self.take_while(|c| c.is_ascii_digit());
                }
                let range = start..self.at;
                match self.text[range.clone()].parse::<f64>() {
                    Ok(number) => Ok(Factor { value: FactorValue::Number(number), range }),
                    Err(_) => Err(ProductError {
                        range,
                        why: "this is not a number",
                        help: "names begin with a letter; numbers look like `2`, `0.25` or `1e-3`",
                    }),
                }
            }
            Some(c) if c.is_ascii_alphabetic() || c == '_' => {
                self.take_while(|c| c.is_ascii_alphanumeric() || c == '_' || c == '.');
                let range = start..self.at;
                Ok(Factor { value: FactorValue::Name(&self.text[range.clone()]), range })
            }
            _ => Err(self.unexpected()),
        }
    }

    fn unexpected(&self) -> ProductError {
        let next = self.peek();
        let range = self.at..self.at + next.map_or(0, char::len_utf8);
        let (why, help) = match next {
            None => ("a factor is missing", SHAPE),
            Some('+') => {
                ("`+` has no place in a product", "a sum is a list of inputs: in = [\"a\", \"b\"]")
            }
            Some('-') => (
                "a minus may only stand at the front",
                "a sum is a list of inputs: in = [\"a\", \"-b\"]; a product takes one leading minus",
            ),
            Some('/') => (
                "`/` has no place in a product",
                "multiply by the reciprocal, or use a `divider` block for two nets",
            ),
            Some('(' | ')') => {
                ("parentheses have no place in a product", "let another block make the inner sum")
            }
            Some(_) => ("this is not a product", SHAPE),
        };
        ProductError { range, why, help }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(text: &str) -> (bool, Vec<FactorValue<'_>>) {
        let product = parse(text).unwrap();
        (product.negative, product.factors.iter().map(|f| f.value).collect())
    }

    #[test]
    fn products_are_read() {
        use FactorValue::{Name, Number};
        assert_eq!(names("x"), (false, vec![Name("x")]));
        assert_eq!(names("-gyro.out"), (true, vec![Name("gyro.out")]));
        assert_eq!(names(" -1e-3*k *x "), (true, vec![Number(1e-3), Name("k"), Name("x")]));
        assert_eq!(names(".5"), (false, vec![Number(0.5)]));
    }

    #[test]
    fn other_arithmetic_is_refused_where_it_stands() {
        for (text, at) in [
            ("", 0),
            ("-", 1),
            ("2 *", 3),
            ("a + b", 2),
            ("a - b", 2),
            ("a / 2", 2),
            ("2x", 1),
            ("2 x", 2),
            ("1.2.3", 0),
            ("1e", 0),
            ("2 * -x", 4),
            ("θ", 0),
        ] {
            assert_eq!(parse(text).unwrap_err().range.start, at, "{text}");
        }
    }
}
