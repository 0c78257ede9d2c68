//! Operations and lines of a function in C or C++, also of code from other tools.
//!
//! Input: texts, and the name of a function in these texts. Output: additions, multiplications, divisions,
//! roots, negations and calls of the function, plus those of each called function in the texts, once per
//! call. Indices, pointers, heads of `if` and `for`, tests of a pointer before a load and quotients of two
//! literals are not counted. A loop body counts once, because loops in kernels only copy and negate.

use forcec::internals::scalar::Operations;
use std::collections::BTreeMap;

#[derive(Clone, PartialEq, Debug)]
enum Token {
    Word(String),
    Number,
    Sign(char),
}

/// Size of a function.
#[derive(Clone, Copy, Default, Debug)]
pub struct Size {
    /// Its operations.
    pub operations: Operations,
    /// Its lines and those of the functions it calls, each function once; blank lines and comments are none.
    pub lines: usize,
}

struct Function {
    tokens: Vec<Token>,
    lines: usize,
}

/// Counts. Panics where the function is not in the texts.
pub fn size(texts: &[&str], function: &str) -> Size {
    let mut functions = BTreeMap::new();
    for text in texts {
        collect(&plain(text), &mut functions);
    }
    assert!(functions.contains_key(function), "no function `{function}` in the texts");
    let mut reached = vec![function.to_owned()];
    let mut lines = 0;
    let mut next = 0;
    while next < reached.len() {
        let called = &functions[&reached[next]];
        lines += called.lines;
        for token in &called.tokens {
            if let Token::Word(word) = token
                && functions.contains_key(word)
                && !reached.contains(word)
            {
                reached.push(word.clone());
            }
        }
        next += 1;
    }
    // Callees precede their callers in C, so a few passes determine every count.
    let mut counts: BTreeMap<&str, Operations> = BTreeMap::new();
    for _ in 0..reached.len() {
        for name in &reached {
            let count = operations(&functions[name].tokens, &counts);
            counts.insert(name, count);
        }
    }
    Size { operations: counts[function], lines }
}

/// The text without comments and lines of the preprocessor; line breaks stay.
fn plain(text: &str) -> String {
    let mut result = String::new();
    let mut rest = text;
    while let Some(start) = rest.find("/*") {
        result.push_str(&rest[..start]);
        rest = rest[start..].split_once("*/").map_or("", |(_, rest)| rest);
    }
    result.push_str(rest);
    let code = |line: &str| -> String {
        let line = line.split_once("//").map_or(line, |(code, _)| code);
        if line.trim_start().starts_with('#') { String::new() } else { line.to_owned() }
    };
    result.lines().map(code).collect::<Vec<_>>().join("\n").replace("extern \"C\"", "")
}

/// Every function with a body.
fn collect(text: &str, functions: &mut BTreeMap<String, Function>) {
    let mut rest = text;
    while let Some(open) = rest.find('{') {
        let head = &rest[..open];
        let mut depth = 0;
        let body = rest[open..].char_indices().find_map(|(i, c)| {
            depth += match c {
                '{' => 1,
                '}' => -1,
                _ => 0,
            };
            (depth == 0).then_some(&rest[open..open + i + 1])
        });
        let Some(body) = body else { return };
        // A namespace is entered, everything else passed over.
        let head = head.rsplit([';', '}']).next().unwrap_or(head).trim_start();
        if head.starts_with("namespace") || head.is_empty() {
            rest = &rest[open + 1..];
            continue;
        }
        if head.trim_end().ends_with(')') {
            let name = head.split_once('(').map_or("", |(name, _)| name.trim_end());
            let name = name.rsplit(|c: char| !c.is_ascii_alphanumeric() && c != '_').next().unwrap_or("");
            let whole = format!("{head}{body}");
            let lines = whole.lines().filter(|line| !line.trim().is_empty()).count();
            functions.insert(name.to_owned(), Function { tokens: tokens(body), lines });
        }
        rest = &rest[open + body.len()..];
    }
}

fn tokens(text: &str) -> Vec<Token> {
    let mut result = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let number =
            first.is_ascii_digit() || first == '.' && rest[1..].starts_with(|c: char| c.is_ascii_digit());
        let mut length = first.len_utf8();
        if number {
            let mut before = ' ';
            length = rest
                .find(|c: char| {
                    let inside = c.is_ascii_alphanumeric()
                        || c == '.'
                        || matches!(c, '+' | '-') && matches!(before, 'e' | 'E');
                    before = c;
                    !inside
                })
                .unwrap_or(rest.len());
            result.push(Token::Number);
        } else if first.is_ascii_alphabetic() || first == '_' {
            length = rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(rest.len());
            result.push(Token::Word(rest[..length].to_owned()));
        } else if rest.starts_with("->") || rest.starts_with("++") || rest.starts_with("--") {
            length = 2;
            result.push(Token::Sign('.'));
        } else if !first.is_whitespace() {
            result.push(Token::Sign(first));
        }
        rest = &rest[length..];
        // `Scalar(2)` is a literal.
        if let [.., Token::Word(cast), Token::Sign('('), Token::Number, Token::Sign(')')] = &result[..]
            && cast == "Scalar"
        {
            result.truncate(result.len() - 4);
            result.push(Token::Number);
        }
    }
    result
}

const TYPES: [&str; 9] =
    ["double", "float", "Scalar", "const", "void", "int", "casadi_real", "casadi_int", "auto"];

fn operations(tokens: &[Token], known: &BTreeMap<&str, Operations>) -> Operations {
    let mut count = Operations::default();
    let (mut index, mut at) = (0, 0);
    while at < tokens.len() {
        let before = at.checked_sub(1).map(|i| &tokens[i]);
        let after = tokens.get(at + 1);
        let value = match before {
            Some(Token::Word(word)) => word != "return" && !TYPES.contains(&word.as_str()),
            Some(Token::Number | Token::Sign(')' | ']')) => true,
            _ => false,
        };
        let literals = before == Some(&Token::Number) && after == Some(&Token::Number);
        match &tokens[at] {
            Token::Sign('[') => index += 1,
            Token::Sign(']') => index -= 1,
            _ if index > 0 => {}
            Token::Word(word) if word == "if" || word == "for" => at = closing(tokens, at + 1),
            Token::Word(word) if known.contains_key(word.as_str()) => count += known[word.as_str()],
            Token::Word(word) if after == Some(&Token::Sign('(')) && !is_index(&tokens[at + 2..]) => {
                match word.as_str() {
                    "sqrt" => count.sqrt += 1,
                    "return" | "sizeof" => {}
                    name if TYPES.contains(&name) => {}
                    _ => count.call += 1,
                }
            }
            Token::Sign('+') if value => count.add += 1,
            Token::Sign('-') if value => count.add += 1,
            Token::Sign('-') if after != Some(&Token::Number) => count.neg += 1,
            Token::Sign('*') if value && after != Some(&Token::Sign(')')) => count.mul += 1,
            Token::Sign('/') if value && !literals => count.div += 1,
            Token::Sign('?') if before != Some(&Token::Sign(']')) => count.call += 1,
            _ => {}
        }
        at += 1;
    }
    count
}

/// Are these, which follow a bracket, nothing or literals up to the bracket that closes it? Such is `m(0, 1)`, an entry
/// of a matrix in C++.
fn is_index(tokens: &[Token]) -> bool {
    let mut inside = tokens.iter().skip_while(|token| matches!(token, Token::Number | Token::Sign(',')));
    inside.next() == Some(&Token::Sign(')'))
}

/// The place of the bracket that closes the one at `open`.
fn closing(tokens: &[Token], open: usize) -> usize {
    let mut depth = 0;
    for (place, token) in tokens.iter().enumerate().skip(open) {
        match token {
            Token::Sign('(') => depth += 1,
            Token::Sign(')') => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return place;
        }
    }
    tokens.len()
}

#[cfg(test)]
mod tests {
    use super::size;

    #[test]
    fn counts_what_is_computed_and_nothing_else() {
        let text = "#define X(a) a*a\n/* 1 + 1 */\nstatic double square(double x) { return x*x;}\n\
                    int f(const double** arg, double** res) {\n  double w0, *rr;\n  w0=(arg[0]? arg[0][1+2] : 0);\n  \
                    if (res[0]!=0) res[0][0]=square(w0)-sqrt(-w0);\n\n  // none - at all\n  \
                    res[1][2]=1.0/2.0*w0/(3e-5 + w0)+pow(w0, -2.);\n  res[1][0]=-square(square(w0));\n  return 0;\n}\n";
        let size = size(&[text], "f");
        let count = size.operations;
        assert_eq!((count.add, count.mul, count.div), (3, 4, 1), "{count:?}");
        assert_eq!((count.sqrt, count.neg, count.call), (1, 2, 1), "{count:?}");
        assert_eq!(size.lines, 9);
    }
}
