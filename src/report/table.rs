//! Tables: rows of named columns, as CSV, as JSON and for the eye.

use crate::math::Real;
use serde::Serialize;
use serde_json::{Map, Value, json};

/// One entry of a table.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Cell {
    /// A word.
    Text(String),
    /// A measurement; what is not finite is written as a word, so that it cannot pass for a number.
    Number(Real),
    /// A whole number.
    Count(u64),
    /// Not known, or not applicable.
    None,
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<Real> for Cell {
    fn from(number: Real) -> Self {
        Self::Number(number)
    }
}

impl From<u64> for Cell {
    fn from(count: u64) -> Self {
        Self::Count(count)
    }
}

impl<T: Into<Cell>> From<Option<T>> for Cell {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::None, Into::into)
    }
}

impl Cell {
    /// In full, for machines; commas and quotes in words are left to `quoted`.
    fn exact(&self) -> String {
        match self {
            Self::Text(text) => text.clone(),
            Self::Number(number) => format!("{number:?}"),
            Self::Count(count) => count.to_string(),
            Self::None => String::new(),
        }
    }

    /// Rounded to four digits, for people.
    fn short(&self) -> String {
        match self {
            Self::Number(0.0) => "0".into(),
            Self::Number(x) if x.abs() >= 1e-3 && x.abs() < 1e6 => {
                let before = libm::log10(x.abs()).floor() as i64;
                format!("{x:.*}", (3 - before).max(0) as usize)
            }
            Self::Number(x) => format!("{x:.3e}"),
            Self::None => "–".into(),
            other => other.exact(),
        }
    }
}

/// Rows under named columns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    columns: Vec<String>,
    rows: Vec<Vec<Cell>>,
}

impl Table {
    /// A table without rows; a column's name carries its unit.
    pub fn new(columns: &[&str]) -> Self {
        Self {
            columns: columns.iter().map(|&c| c.to_owned()).collect(),
            rows: Vec::new(),
        }
    }

    /// Adds a row: one entry a column.
    pub fn row(&mut self, cells: Vec<Cell>) {
        assert_eq!(cells.len(), self.columns.len(), "one entry a column");
        self.rows.push(cells);
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Comma-separated, the first line names the columns; words with commas are quoted (RFC 4180).
    pub fn to_csv(&self) -> String {
        let line = |cells: Vec<String>| {
            let quoted: Vec<String> = cells.iter().map(|c| quoted(c)).collect();
            quoted.join(",") + "\n"
        };
        let mut text = line(self.columns.clone());
        for row in &self.rows {
            text += &line(row.iter().map(Cell::exact).collect());
        }
        text
    }

    /// An array with an object for each row.
    pub fn to_json(&self) -> Value {
        let object = |row: &Vec<Cell>| -> Value {
            let entries = self.columns.iter().zip(row);
            let entries = entries.map(|(name, cell)| {
                let value = match cell {
                    Cell::Number(x) if !x.is_finite() => json!(x.to_string()),
                    cell => json!(cell),
                };
                (name.clone(), value)
            });
            Value::Object(entries.collect::<Map<_, _>>())
        };
        self.rows.iter().map(object).collect()
    }

    /// In columns, for the eye; words to the left, numbers to the right.
    pub fn to_text(&self) -> String {
        let cells: Vec<Vec<String>> = self
            .rows
            .iter()
            .map(|row| row.iter().map(Cell::short).collect())
            .collect();
        let widths: Vec<usize> = (0..self.columns.len())
            .map(|k| {
                let column = cells.iter().map(|row| &row[k]).chain([&self.columns[k]]);
                column.map(|c| c.chars().count()).max().unwrap_or(0)
            })
            .collect();
        let is_word =
            |k: usize| -> bool { self.rows.iter().any(|row| matches!(row[k], Cell::Text(_))) };
        let line = |cells: &[String]| {
            let padded = cells.iter().enumerate().map(|(k, cell)| {
                let width = widths[k];
                if is_word(k) {
                    format!("{cell:<width$}")
                } else {
                    format!("{cell:>width$}")
                }
            });
            padded.collect::<Vec<_>>().join("  ").trim_end().to_owned() + "\n"
        };
        let mut text = line(&self.columns);
        for row in &cells {
            text += &line(row);
        }
        text
    }
}

fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> Table {
        let mut table = Table::new(&["case", "error [1]", "steps"]);
        table.row(vec![
            "wave, \"thin\"".into(),
            0.012_345_678.into(),
            7.into(),
        ]);
        table.row(vec!["rest".into(), Real::NAN.into(), Cell::None]);
        table
    }

    #[test]
    fn csv_keeps_every_digit_and_quotes_commas() {
        assert_eq!(
            sample().to_csv(),
            "case,error [1],steps\n\"wave, \"\"thin\"\"\",0.012345678,7\nrest,NaN,\n"
        );
    }

    #[test]
    fn json_says_what_is_not_a_number() {
        let json = sample().to_json();
        assert_eq!(json[0]["error [1]"], 0.012_345_678);
        assert_eq!(json[1]["error [1]"], "NaN");
        assert!(json[1]["steps"].is_null());
    }

    #[test]
    fn text_lines_up() {
        assert_eq!(
            sample().to_text(),
            "case          error [1]  steps\nwave, \"thin\"    0.01235      7\nrest                NaN      –\n"
        );
    }
}
