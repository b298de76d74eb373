//! `pelage texel kinds`: what grows, and everything that can be set of it.

use std::fmt::Write as _;
use std::io::Write as _;

use clap::Args;
use pelage::scene_file::TexelEntry;
use pelage::texel::{Kind, Parameter, Preset, Procedure};

use crate::failure::Failure;

#[derive(Args)]
pub struct KindsArgs {
    /// One of them, or one of its presets as in fur:plush [default: list all]
    kind: Option<String>,

    /// Everything about all of them, as a page of Markdown
    #[arg(long, conflicts_with = "kind")]
    markdown: bool,
}

/// Tells on stdout.
pub fn run(args: &KindsArgs) -> Result<(), Failure> {
    let text = match &args.kind {
        Some(word) => described(word)?,
        None if args.markdown => markdown(),
        None => list(),
    };
    std::io::stdout().write_all(text.as_bytes()).map_err(Failure::Stdout)
}

/// Every kind once, in order, with its presets.
fn kinds() -> Vec<(&'static str, Vec<Preset>)> {
    let mut kinds: Vec<(&str, Vec<Preset>)> = Vec::new();
    for preset in Kind::PRESETS {
        match kinds.last_mut() {
            Some((kind, presets)) if *kind == preset.kind => presets.push(preset),
            _ => kinds.push((preset.kind, vec![preset])),
        }
    }
    kinds
}

/// What a number may be and what it counts: `0 to 1 texel edges`.
fn range(parameter: &Parameter) -> String {
    format!("{} {}", parameter.domain.name, parameter.unit).trim_end().to_owned()
}

fn list() -> String {
    let mut text = String::new();
    for (kind, presets) in kinds() {
        let names: Vec<&str> = presets.iter().map(|preset| preset.name).collect();
        let _ = writeln!(text, "{kind:12} {}", names.join(", "));
    }
    text + "\n`pelage texel kinds fur` tells what can be set of fur, `pelage texel kinds fur:plush` its values in a preset.\n"
}

fn described(word: &str) -> Result<String, Failure> {
    let entry = TexelEntry::from_word(word).map_err(Failure::Usage)?;
    let TexelEntry::Grown { kind, .. } = entry else {
        return Err(Failure::Usage(format!(
            "{word}: a texel file is no kind; `pelage texel info` tells of it"
        )));
    };
    let name = kind.name();
    let mut text = format!("{name}: {}\n\nPresets\n", kind.about());
    for (i, preset) in Kind::PRESETS.iter().filter(|preset| preset.kind == name).enumerate() {
        let default = if i == 0 { " (the default)" } else { "" };
        let _ = writeln!(text, "  {:8} {}{default}", preset.name, preset.about);
    }
    let _ = writeln!(text, "\nParameters, as they are in {word}");
    for parameter in kind.parameters() {
        let _ = writeln!(text, "  {} = {}", parameter.name, parameter.value);
        let _ = writeln!(text, "      {} From {}.", parameter.meaning, range(&parameter));
    }
    Ok(text.replace("From any", "Any"))
}

fn markdown() -> String {
    let mut text = String::from(
        "# The kinds of content that grow\n\n\
         Written by `pelage texel kinds --markdown`. In a scene file `texel.fur = { preset = \"plush\", count = 900 }` is the\n\
         preset `plush` with another `count`; `pelage texel grow fur --preset plush --set count=900 -o x.texel` keeps the same\n\
         in a file. Lengths are in texel edges, where a copy is 1 wide and 1 high; colours are linear albedos; a slope is in\n\
         texel edges a texel edge.\n",
    );
    for (kind, presets) in kinds() {
        let made: Vec<Vec<Parameter>> = presets.iter().map(|preset| (preset.make)().parameters()).collect();
        let about = presets.first().map(|preset| (preset.make)().about()).unwrap_or_default();
        let _ = writeln!(text, "\n## `{kind}`\n\n{about}\n");
        for preset in &presets {
            let _ = writeln!(text, "- `{}`: {}", preset.name, preset.about);
        }
        let names: Vec<String> = presets.iter().map(|preset| format!("`{}`", preset.name)).collect();
        let _ = writeln!(text, "\n| field | {} | from | |", names.join(" | "));
        let _ = writeln!(text, "|---{}|---|---|", "|---".repeat(presets.len()));
        for (row, parameter) in made.first().into_iter().flatten().enumerate() {
            let values: Vec<String> = made.iter().map(|of| of[row].value.to_string()).collect();
            let Parameter { name, meaning, .. } = parameter;
            let _ =
                writeln!(text, "| `{name}` | {} | {} | {meaning} |", values.join(" | "), range(parameter));
        }
    }
    text
}
