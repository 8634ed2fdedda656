//! References, and arithmetic over them.

use serde_json::Value;

use super::Resolve;

/// Keys, and last a path.
#[derive(Debug)]
pub struct Reference(Vec<String>);

impl Reference {
    fn parse(text: &str) -> Result<Self, String> {
        let parts: Vec<String> = text.split('|').map(|part| part.trim().into()).collect();
        if parts.iter().any(String::is_empty) {
            return Err(format!("an empty part in `{text}`"));
        }
        Ok(Self(parts))
    }

    pub fn keys(&self) -> &[String] {
        &self.0[..self.0.len() - 1]
    }

    pub fn path(&self) -> &str {
        self.0.last().expect("at least one part")
    }
}

#[derive(Debug)]
enum Term {
    Number(f64),
    Reference(Reference),
}

/// A sum of products.
#[derive(Debug)]
pub struct Expression(Vec<(Sign, Product)>);

#[derive(Debug, Clone, Copy)]
enum Sign {
    Plus,
    Minus,
}

/// The first term is multiplied with, or divided by, the others.
#[derive(Debug)]
struct Product(Term, Vec<(Factor, Term)>);

#[derive(Debug, Clone, Copy)]
enum Factor {
    Times,
    Over,
}

impl Expression {
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut terms = Vec::new();
        for (sign, product) in split(text, &[(" + ", Sign::Plus), (" - ", Sign::Minus)]) {
            let mut factors = split(product, &[(" * ", Factor::Times), (" / ", Factor::Over)]);
            let (_, first) = factors.remove(0);
            let factors: Result<_, String> = factors
                .into_iter()
                .map(|(factor, text)| Ok((factor.expect("all but the first"), term(text)?)))
                .collect();
            terms.push((sign.unwrap_or(Sign::Plus), Product(term(first)?, factors?)));
        }
        Ok(Self(terms))
    }

    /// The value; `None` if some part of it was not measured.
    pub fn value(&self, from: &dyn Resolve) -> Result<Option<Value>, String> {
        // A single reference may be of any type.
        if let [(Sign::Plus, Product(Term::Reference(reference), factors))] = &self.0[..]
            && factors.is_empty()
        {
            return Ok(from.resolve(reference)?.filter(|value| !value.is_null()));
        }
        let mut sum = 0.0;
        for (sign, Product(first, factors)) in &self.0 {
            let Some(mut product) = number(first, from)? else {
                return Ok(None);
            };
            for (factor, term) in factors {
                let Some(number) = number(term, from)? else {
                    return Ok(None);
                };
                match factor {
                    Factor::Times => product *= number,
                    Factor::Over => product /= number,
                }
            }
            sum += match sign {
                Sign::Plus => product,
                Sign::Minus => -product,
            };
        }
        // `None` after a division by zero.
        Ok(serde_json::Number::from_f64(sum).map(Value::Number))
    }
}

fn term(text: &str) -> Result<Term, String> {
    let text = text.trim();
    match text.parse::<f64>() {
        Ok(number) => Ok(Term::Number(number)),
        Err(_) => Ok(Term::Reference(Reference::parse(text)?)),
    }
}

fn number(term: &Term, from: &dyn Resolve) -> Result<Option<f64>, String> {
    match term {
        Term::Number(number) => Ok(Some(*number)),
        Term::Reference(reference) => match from.resolve(reference)? {
            None | Some(Value::Null) => Ok(None),
            Some(value) => {
                let number = value.as_f64();
                Ok(Some(
                    number.ok_or(format!("{} is no number", reference.path()))?,
                ))
            }
        },
    }
}

/// The parts of `text`, each but the first with the separator before it.
fn split<'a, T: Copy>(mut text: &'a str, between: &[(&str, T)]) -> Vec<(Option<T>, &'a str)> {
    let mut parts = Vec::new();
    let mut before = None;
    loop {
        let next = between
            .iter()
            .filter_map(|(mark, what)| Some((text.find(mark)?, mark.len(), *what)))
            .min_by_key(|(place, ..)| *place);
        let Some((place, length, what)) = next else {
            parts.push((before, text));
            return parts;
        };
        parts.push((before, &text[..place]));
        before = Some(what);
        text = &text[place + length..];
    }
}
