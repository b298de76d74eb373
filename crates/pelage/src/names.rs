//! Messages for names that nothing has: the nearest ones that something does have.

use std::collections::BTreeSet;

/// Says that no `kind` is called `name`, and which of the `known` names may have been meant.
pub(crate) fn unknown<'a>(kind: &str, name: &str, known: impl Iterator<Item = &'a str>) -> String {
    format!("{}: {}", missing(kind, name), nearest(name, known))
}

/// Says that no `kind` is called `name`.
pub(crate) fn missing(kind: &str, name: &str) -> String {
    format!("there is no {kind} `{name}`")
}

/// Says which of the `known` names may have been meant by one that is none of them.
pub(crate) fn nearest<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> String {
    const SHOWN: usize = 6;
    let known: BTreeSet<&str> = known.filter(|n| !n.is_empty()).collect();
    if known.is_empty() {
        return "none has a name".into();
    }
    let mut near: Vec<(usize, &str)> = known.iter().map(|n| (distance(name, n), *n)).collect();
    near.sort_unstable();
    let close = |&&(d, n): &&(usize, &str)| 2 * d <= n.chars().count();
    let list = |names: &mut dyn Iterator<Item = &(usize, &str)>| {
        names.take(SHOWN).map(|(_, n)| format!("`{n}`")).collect::<Vec<_>>().join(", ")
    };
    let meant = list(&mut near.iter().filter(close));
    if !meant.is_empty() {
        return format!("did you mean {meant}?");
    }
    let more = if near.len() > SHOWN { format!(" and {} more", near.len() - SHOWN) } else { String::new() };
    format!("there are {}{more}", list(&mut near.iter()))
}

/// How many letters must be changed, added or dropped, regardless of case. [Levenshtein]
fn distance(a: &str, b: &str) -> usize {
    // Names come from files and may be long; beyond this nothing is a slip of the hand.
    const LETTERS: usize = 64;
    let letters = |s: &str| s.chars().take(LETTERS).flat_map(char::to_lowercase).collect::<Vec<_>>();
    let (a, b) = (letters(a), letters(b));
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.iter().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let changed = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = changed.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_misses_come_first() {
        assert_eq!(distance("kitten", "sitting"), 3);
        assert_eq!(distance("Body", "body"), 0);
        let known = ["Body", "Eyes", "Ground"];
        assert_eq!(unknown("mesh", "Bdy", known.into_iter()), "there is no mesh `Bdy`: did you mean `Body`?");
        assert_eq!(
            unknown("mesh", "Tail", known.into_iter()),
            "there is no mesh `Tail`: there are `Body`, `Eyes`, `Ground`"
        );
        assert_eq!(unknown("mesh", "x", [""].into_iter()), "there is no mesh `x`: none has a name");
    }
}
