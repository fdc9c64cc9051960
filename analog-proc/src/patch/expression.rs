//! Arithmetic as it is written in a patch: `-c1 * c2 * net`, `2 * pi * f`, `1 / (R * C)`, `10ms`.
//!
//! Numbers, parameters and `pi` joined by `+ - * /` and parentheses, and the functions of
//! [`Function`]. It is done once, when the patch is read, and only with numbers: nets are summed
//! by a list of inputs and multiplied by blocks, so that every operation of the running patch is a
//! block. A number may carry `s`, `ms`, `us` or `ns`; it then means so many seconds.

use std::ops::Range;

/// A part of an expression and its place in the string.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Expression<'a> {
    pub(crate) node: Node<'a>,
    pub(crate) range: Range<usize>,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Node<'a> {
    Number(f64),
    Name(&'a str),
    Negative(Box<Expression<'a>>),
    /// Operands joined by operators of one rank, from left to right.
    Chain(Box<Expression<'a>>, Vec<(Binary, Expression<'a>)>),
    Call(Function, Vec<Expression<'a>>),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Binary {
    Add,
    Subtract,
    Multiply,
    Divide,
}

impl Binary {
    pub(crate) fn of(self, a: f64, b: f64) -> f64 {
        match self {
            Binary::Add => a + b,
            Binary::Subtract => a - b,
            Binary::Multiply => a * b,
            Binary::Divide => a / b,
        }
    }
}

/// A function of numbers: its name and what it makes of its arguments.
#[derive(Clone, Copy)]
pub(crate) struct Function {
    name: &'static str,
    arguments: usize,
    of: fn(&[f64]) -> f64,
}

const FUNCTIONS: [Function; 6] = [
    Function { name: "sqrt", arguments: 1, of: |x| x[0].sqrt() },
    Function { name: "sin", arguments: 1, of: |x| libm::sin(x[0]) },
    Function { name: "cos", arguments: 1, of: |x| libm::cos(x[0]) },
    Function { name: "exp", arguments: 1, of: |x| libm::exp(x[0]) },
    Function { name: "min", arguments: 2, of: |x| x[0].min(x[1]) },
    Function { name: "max", arguments: 2, of: |x| x[0].max(x[1]) },
];

impl Function {
    pub(crate) fn of(self, arguments: &[f64]) -> f64 {
        (self.of)(arguments)
    }
}

impl std::fmt::Debug for Function {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name)
    }
}

impl PartialEq for Function {
    fn eq(&self, other: &Function) -> bool {
        self.name == other.name
    }
}

/// Why an expression cannot be read, where, and what to write instead.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ExpressionError {
    pub(crate) range: Range<usize>,
    pub(crate) why: &'static str,
    pub(crate) help: &'static str,
}

const SHAPE: &str = "write a net or a product that ends in one, such as `-2.5 * net`, or arithmetic with numbers and parameters, such as `2 * pi * f` or `1 / (R * C)`";
/// Deepest nesting of parentheses and signs.
const DEEPEST: usize = 64;

/// Reads an expression.
pub(crate) fn parse(text: &str) -> Result<Expression<'_>, ExpressionError> {
    let mut rest = Cursor { text, at: 0, depth: 0 };
    let expression = rest.sum()?;
    if rest.at < text.len() { Err(rest.unexpected()) } else { Ok(expression) }
}

/// Whether a text can name a parameter, block, port or instance.
pub(crate) fn is_name(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        && text.len() <= 120
}

/// A net and what it is multiplied with.
#[derive(Debug, PartialEq)]
pub(crate) struct WeightedNet<'a> {
    /// The net's name …
    pub(crate) net: &'a str,
    /// … and its place.
    pub(crate) range: Range<usize>,
    /// 1 where there is none.
    pub(crate) coefficient: Option<Expression<'a>>,
}

impl<'a> Expression<'a> {
    /// Every name in it.
    pub(crate) fn names(&self) -> Vec<&'a str> {
        match &self.node {
            Node::Number(_) => Vec::new(),
            Node::Name(name) => vec![name],
            Node::Negative(inner) => inner.names(),
            Node::Chain(first, rest) => {
                first.names().into_iter().chain(rest.iter().flat_map(|(_, e)| e.names())).collect()
            }
            Node::Call(_, arguments) => arguments.iter().flat_map(Expression::names).collect(),
        }
    }

    /// As an input of a block: a net, alone or as the last factor of a product.
    pub(crate) fn into_input(self) -> Result<WeightedNet<'a>, ExpressionError> {
        let refused = |range, why, help| Err(ExpressionError { range, why, help });
        let range = self.range;
        match self.node {
            Node::Name(net) => Ok(WeightedNet { net, range, coefficient: None }),
            Node::Negative(inner) => {
                let mut input = inner.into_input()?;
                let one = || Expression { node: Node::Number(1.0), range: range.clone() };
                let coefficient = input.coefficient.unwrap_or_else(one);
                let node = Node::Negative(Box::new(coefficient));
                input.coefficient = Some(Expression { node, range });
                Ok(input)
            }
            Node::Chain(first, mut rest) => match rest.pop() {
                Some((Binary::Multiply, Expression { node: Node::Name(net), range: at })) => {
                    let end = rest.last().map_or(first.range.end, |(_, e)| e.range.end);
                    let node = Node::Chain(first, rest);
                    let coefficient = Some(Expression { node, range: range.start..end });
                    Ok(WeightedNet { net, range: at, coefficient })
                }
                Some((Binary::Multiply, last)) => refused(
                    last.range,
                    "the last factor must be a net",
                    "write the net last and alone: `0.5 * x`, `(a - b) * x`",
                ),
                Some((Binary::Divide, _)) => refused(
                    range,
                    "an input is a net or a product that ends in one",
                    "write the net last: `1 / tau * x`; two nets are divided by a `divider` block",
                ),
                Some(_) => refused(
                    range,
                    "an input is one net",
                    "a sum is a list of inputs: in = [\"a\", \"-b\"]",
                ),
                None => first.into_input(),
            },
            Node::Number(_) => refused(
                range,
                "the last factor must be a net",
                "write `0.5 * x`; a number alone needs a `constant` block, { kind = \"constant\", value = 0.5 }",
            ),
            Node::Call(..) => refused(
                range,
                "a function of a net is a block",
                "wire one of the kinds `sine`, `cosine`, `square-root`, `min`, `max`; a coefficient stands before its net: `sqrt(k) * x`",
            ),
        }
    }
}

struct Cursor<'a> {
    text: &'a str,
    at: usize,
    depth: usize,
}

impl<'a> Cursor<'a> {
    fn peek(&self) -> Option<char> {
        self.text[self.at..].chars().next()
    }

    fn skip_space(&mut self) {
        self.take_while(char::is_whitespace);
    }

    /// Takes one of `wanted` with the space before and behind it.
    fn take(&mut self, wanted: &[char]) -> Option<char> {
        self.skip_space();
        let found = self.peek().filter(|c| wanted.contains(c))?;
        self.at += found.len_utf8();
        self.skip_space();
        Some(found)
    }

    fn take_while(&mut self, accept: impl Fn(char) -> bool) {
        while let Some(c) = self.peek().filter(|c| accept(*c)) {
            self.at += c.len_utf8();
        }
    }

    fn sum(&mut self) -> Result<Expression<'a>, ExpressionError> {
        self.chain(Cursor::product, &['+', '-'])
    }

    fn product(&mut self) -> Result<Expression<'a>, ExpressionError> {
        self.chain(Cursor::factor, &['*', '/'])
    }

    fn chain(
        &mut self,
        operand: fn(&mut Cursor<'a>) -> Result<Expression<'a>, ExpressionError>,
        operators: &[char],
    ) -> Result<Expression<'a>, ExpressionError> {
        let first = operand(self)?;
        let mut rest = Vec::new();
        while let Some(operator) = self.take(operators) {
            let operator = match operator {
                '+' => Binary::Add,
                '-' => Binary::Subtract,
                '*' => Binary::Multiply,
                _ => Binary::Divide,
            };
            rest.push((operator, operand(self)?));
        }
        let Some((_, last)) = rest.last() else { return Ok(first) };
        let range = first.range.start..last.range.end;
        Ok(Expression { node: Node::Chain(Box::new(first), rest), range })
    }

    fn factor(&mut self) -> Result<Expression<'a>, ExpressionError> {
        self.skip_space();
        let start = self.at;
        self.depth += 1;
        if self.depth > DEEPEST {
            let help = "give a part of it a name under [params]";
            return Err(ExpressionError {
                range: start..start,
                why: "this is nested too deeply",
                help,
            });
        }
        let node = match self.peek() {
            Some('-') => {
                self.at += 1;
                Node::Negative(Box::new(self.factor()?))
            }
            Some('(') => {
                self.at += 1;
                let inner = self.sum()?;
                self.close()?;
                self.depth -= 1;
                self.skip_space();
                return Ok(inner);
            }
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(start)?,
            Some(c) if c.is_ascii_alphabetic() || c == '_' => {
                self.take_while(|c| c.is_ascii_alphanumeric() || c == '_' || c == '.');
                let name = &self.text[start..self.at];
                let end = self.at;
                match self.take(&['(']) {
                    Some(_) => self.call(name, start..end)?,
                    None => {
                        self.at = end;
                        Node::Name(name)
                    }
                }
            }
            _ => return Err(self.unexpected()),
        };
        self.depth -= 1;
        let range = start..self.at;
        self.skip_space();
        Ok(Expression { node, range })
    }

    fn close(&mut self) -> Result<(), ExpressionError> {
        self.take(&[')']).map(drop).ok_or_else(|| self.unexpected())
    }

    fn call(&mut self, name: &str, range: Range<usize>) -> Result<Node<'a>, ExpressionError> {
        let Some(function) = FUNCTIONS.into_iter().find(|f| f.name == name) else {
            let help = "the functions of numbers are sqrt, sin, cos, exp, min, max; a product is written with `*`";
            return Err(ExpressionError { range, why: "there is no such function", help });
        };
        let mut arguments = vec![self.sum()?];
        while self.take(&[',']).is_some() {
            arguments.push(self.sum()?);
        }
        let range = range.start..self.at;
        self.close()?;
        if arguments.len() == function.arguments {
            return Ok(Node::Call(function, arguments));
        }
        let help = "sqrt, sin, cos and exp take one number, min and max take two";
        Err(ExpressionError { range, why: "this is not how many numbers it takes", help })
    }

    fn number(&mut self, start: usize) -> Result<Node<'a>, ExpressionError> {
        self.take_while(|c| c.is_ascii_digit() || c == '.' || c == '_');
        if matches!(self.peek(), Some('e' | 'E')) {
            self.at += 1;
            if matches!(self.peek(), Some('+' | '-')) {
                self.at += 1;
            }
            self.take_while(|c| c.is_ascii_digit());
        }
        let Ok(number) = self.text[start..self.at].parse::<f64>() else {
            return Err(ExpressionError {
                range: start..self.at,
                why: "this is not a number",
                help: "names begin with a letter; numbers look like `2`, `0.25` or `1e-3`",
            });
        };
        let digits = self.at;
        self.take_while(char::is_alphanumeric);
        // Divided, so that 10ms is the very number 0.01.
        let seconds = match &self.text[digits..self.at] {
            "" | "s" => number,
            "ms" => number / 1e3,
            "us" | "µs" => number / 1e6,
            "ns" => number / 1e9,
            _ => {
                self.at = digits;
                number
            }
        };
        Ok(Node::Number(seconds))
    }

    fn unexpected(&self) -> ExpressionError {
        let next = self.peek();
        let range = self.at..self.at + next.map_or(0, char::len_utf8);
        let why = match next {
            None => "something is missing here",
            Some(')') => "this closes nothing",
            Some(_) => "this has no place here",
        };
        ExpressionError { range, why, help: SHAPE }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Value of an expression whose names are all 2.
    fn value(expression: &Expression<'_>) -> f64 {
        match &expression.node {
            Node::Number(number) => *number,
            Node::Name(_) => 2.0,
            Node::Negative(inner) => -value(inner),
            Node::Chain(first, rest) => {
                rest.iter().fold(value(first), |a, (operator, b)| operator.of(a, value(b)))
            }
            Node::Call(f, arguments) => f.of(&arguments.iter().map(value).collect::<Vec<_>>()),
        }
    }

    #[test]
    fn arithmetic_has_its_usual_order() {
        for (text, expected) in [
            ("1 + 2 * 3", 7.0),
            ("(1 + 2) * 3", 9.0),
            ("8 / 2 / 2", 2.0),
            ("5 - 2 - 1", 2.0),
            ("-a * 3 + 1", -5.0),
            ("2 * -a", -4.0),
            ("sqrt(a * 8) + max(1, min(a, 3))", 6.0),
            ("exp(0) + cos(0) + sin(0)", 2.0),
            ("10ms + 1 s", f64::NAN),
            ("10ms", 0.01),
            ("200us + 5ns", 2e-4 + 5e-9),
            ("a/10ms", 200.0),
            (".5", 0.5),
        ] {
            let found = parse(text).map_or(f64::NAN, |e| value(&e));
            assert!(found == expected || found.is_nan() && expected.is_nan(), "{text}: {found}");
        }
    }

    #[test]
    fn an_input_is_a_net_behind_its_coefficient() {
        for (text, net, coefficient) in [
            ("x", "x", None),
            ("-gyro.out", "gyro.out", Some(-1.0)),
            (" -1e-3*k *x ", "x", Some(-2e-3)),
            ("(k - 1) / 4 * x", "x", Some(0.25)),
            ("-(k * x)", "x", Some(-2.0)),
        ] {
            let input = parse(text).unwrap().into_input().unwrap();
            assert_eq!(
                (input.net, input.coefficient.as_ref().map(value)),
                (net, coefficient),
                "{text}"
            );
            assert_eq!(&text[input.range], net);
        }
        for text in ["a + b", "a - b", "a / 2", "3", "2 * (x)  * 3", "sin(x)", "2 * -x", "x * 2"] {
            assert!(parse(text).unwrap().into_input().is_err(), "{text}");
        }
    }

    #[test]
    fn what_cannot_be_read_is_refused_where_it_stands() {
        for (text, at) in [
            ("", 0),
            ("-", 1),
            ("2 *", 3),
            ("2x", 1),
            ("2 x", 2),
            ("2mm", 1),
            ("1.2.3", 0),
            ("1e", 0),
            ("θ", 0),
            ("(a", 2),
            ("a)", 1),
            ("tan(a)", 0),
            ("sqrt()", 5),
            ("sqrt(1, 2)", 0),
            ("min(1)", 0),
            ("a ** b", 3),
        ] {
            assert_eq!(parse(text).unwrap_err().range.start, at, "{text}");
        }
        for deep in [format!("{}1{}", "(".repeat(500), ")".repeat(500)), "-".repeat(500)] {
            assert_eq!(parse(&deep).unwrap_err().why, "this is nested too deeply");
        }
    }
}
