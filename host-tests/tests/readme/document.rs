//! A page with parts that are computed: between `<!-- KIND:NAME -->` and `<!-- /KIND -->`.

/// The page, and what was put into it.
pub struct Document {
    text: String,
    changes: String,
}

impl Document {
    pub fn new(text: String) -> Self {
        Self { text, changes: String::new() }
    }

    pub fn text(&self) -> &str {
        &self.text
    }

    /// The parts that were not what was put there, before and after.
    pub fn changes(&self) -> &str {
        &self.changes
    }

    /// Replaces the part `name`, as in `table:memory`.
    pub fn put(&mut self, name: &str, body: &str) {
        let kind = name.split(':').next().unwrap_or(name);
        let (open, close) = (format!("<!-- {name} -->\n"), format!("<!-- /{kind} -->"));
        let start = self.text.find(&open).unwrap_or_else(|| panic!("no line {open}")) + open.len();
        let end =
            start + self.text[start..].find(&close).unwrap_or_else(|| panic!("no {close} after {open}"));
        let old = &self.text[start..end];
        if old != body {
            self.changes += &format!("\n{name} is\n{old}and should be\n{body}");
            self.text.replace_range(start..end, body);
        }
    }

    /// Lines with a decimal fraction that are neither computed nor code.
    pub fn unchecked_numbers(&self) -> Vec<&str> {
        let (mut computed, mut code) = (false, false);
        let mut lines = Vec::new();
        for line in self.text.lines() {
            computed = (computed || line.starts_with("<!-- table:") || line.starts_with("<!-- output:"))
                && !line.starts_with("<!-- /");
            code ^= line.starts_with("```");
            let prose = line.split('`').step_by(2).collect::<String>().replace("Rust 1.", "");
            if !computed && !code && has_fraction(&prose) {
                lines.push(line);
            }
        }
        lines
    }
}

/// Whether there is a point between two digits.
fn has_fraction(text: &str) -> bool {
    text.as_bytes()
        .windows(3)
        .any(|three| three[0].is_ascii_digit() && three[1] == b'.' && three[2].is_ascii_digit())
}

/// A table in Markdown.
pub fn table(header: &[&str], rows: &[Vec<String>]) -> String {
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let header: Vec<_> = header.iter().map(|&head| head.to_owned()).collect();
    let rule = vec!["---".to_owned(); header.len()];
    [header, rule].iter().chain(rows).map(|cells| line(cells)).collect()
}

/// `value` with two significant digits.
pub fn rounded(value: f64) -> String {
    if value <= 0.0 {
        return "0".to_owned();
    }
    let place = 1 - value.log10().floor() as i32;
    let unit = 10f64.powi(-place);
    format!("{:.*}", place.max(0) as usize, (value / unit).round() * unit)
}

/// What a block of verbatim text looks like.
pub fn verbatim(text: &str) -> String {
    format!("```text\n{}\n```\n", text.trim_end())
}
