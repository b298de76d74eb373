//! What went wrong, for people: one line, and the place in the scene file where it stands.

use std::fmt;
use std::io::{IsTerminal, stderr};

use miette::{
    Diagnostic, GraphicalReportHandler, GraphicalTheme, LabeledSpan, NamedSource, Severity, SourceCode,
};
use pelage::{Field, Span};

use crate::progress::say;

/// Says a line about a field, and shows the field with a remark beside it where it stands in a text.
pub fn tell(line: impl fmt::Display, field: &Field, remark: &str, severity: Severity) {
    say(line);
    if let Some(picture) = snippet(field, remark, severity) {
        say(picture.trim_end());
    }
}

/// The lines of the file around a field, the field underlined.
fn snippet(field: &Field, remark: &str, severity: Severity) -> Option<String> {
    let Span { bytes, .. } = field.span.as_deref()?;
    let text = std::fs::read_to_string(&field.file).ok()?;
    // It may have been changed since.
    text.get(bytes.clone())?;
    // Of what goes over many lines, where it begins.
    let first_line = text[bytes.clone()].lines().next().unwrap_or_default();
    let snippet = Snippet {
        source: NamedSource::new(field.file.display().to_string(), text.clone()),
        label: LabeledSpan::at(bytes.start..bytes.start + first_line.len(), remark),
        severity,
    };
    let colours = stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty());
    let theme = if colours { GraphicalTheme::unicode() } else { GraphicalTheme::unicode_nocolor() };
    let handler = GraphicalReportHandler::new_themed(theme).with_links(false).with_wrap_lines(false);
    let mut drawn = String::new();
    handler.with_context_lines(1).render_report(&mut drawn, &snippet).ok()?;
    // The first line is the message's, which has been said.
    drawn.split_once('\n').map(|(_, picture)| picture.to_owned())
}

#[derive(Debug)]
struct Snippet {
    source: NamedSource<String>,
    label: LabeledSpan,
    severity: Severity,
}

impl fmt::Display for Snippet {
    fn fmt(&self, _: &mut fmt::Formatter<'_>) -> fmt::Result {
        Ok(())
    }
}

impl std::error::Error for Snippet {}

impl Diagnostic for Snippet {
    fn severity(&self) -> Option<Severity> {
        Some(self.severity)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        Some(&self.source)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        Some(Box::new(std::iter::once(self.label.clone())))
    }
}
