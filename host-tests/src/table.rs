//! Aligned columns and colour for people; colour is taken out again where the output is no terminal.

use std::fmt;

use anstyle::Style;

/// Headings.
pub const BOLD: Style = Style::new().bold();
/// What matters less.
pub const FAINT: Style = Style::new().dimmed();

/// `text` in `style`.
pub fn paint(style: Style, text: &str) -> String {
    format!("{style}{text}{style:#}")
}

/// Rows of cells; the last column is aligned left, the others right.
#[derive(Clone, Debug)]
pub struct Table {
    header: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table with these column heads.
    pub fn new(header: &[&str]) -> Self {
        Self { header: header.iter().map(|&head| head.to_owned()).collect(), rows: Vec::new() }
    }

    /// Adds a row below.
    pub fn row(&mut self, cells: Vec<String>) {
        self.rows.push(cells);
    }

    fn line(&self, cells: &[String], widths: &[usize]) -> String {
        let last = self.header.len().saturating_sub(1);
        let cell = |(index, (cell, width)): (usize, (&String, &usize))| {
            if index == last { cell.clone() } else { format!("{cell:>width$}") }
        };
        let line: Vec<_> = cells.iter().zip(widths).enumerate().map(cell).collect();
        format!("  {}", line.join("  ")).trim_end().to_owned()
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = |column: usize| {
            let cells = std::iter::once(&self.header).chain(&self.rows).filter_map(|row| row.get(column));
            cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
        };
        let widths: Vec<_> = (0..self.header.len()).map(width).collect();
        writeln!(f, "{}", paint(BOLD, &self.line(&self.header, &widths)))?;
        self.rows.iter().try_for_each(|row| writeln!(f, "{}", self.line(row, &widths)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_line_up() {
        let mut table = Table::new(&["n", "px", "flags"]);
        table.row(vec!["1".into(), "12.50".into(), "small".into()]);
        table.row(vec!["10".into(), "1.00".into(), "".into()]);
        let plain = anstream::adapter::strip_str(&table.to_string()).to_string();
        assert_eq!(plain, "   n     px  flags\n   1  12.50  small\n  10   1.00\n");
    }
}
