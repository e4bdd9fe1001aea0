//! Why there is no correspondence.

use std::fmt;

use super::MIN_CODED;

/// Why there is no correspondence. The text says what is missing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MatchError {
    /// Nothing was measured.
    NoTargets,
    /// The layout has too few targets with ids.
    Layout {
        /// How many it has.
        coded: usize,
    },
    /// Too few targets with ids of the layout.
    TooFewCoded {
        /// Targets that were measured.
        measured: usize,
        /// Ids of the layout that were measured once.
        usable: Vec<u16>,
        /// Ids that were measured more than once.
        duplicates: Vec<u16>,
        /// Ids that are not on the layout.
        foreign: Vec<u16>,
    },
    /// The coded targets leave the map open.
    Collinear {
        /// Their ids.
        ids: Vec<u16>,
    },
    /// The coded targets do not lie as on the layout.
    Contradiction {
        /// Their ids.
        ids: Vec<u16>,
    },
}

impl std::error::Error for MatchError {}

impl fmt::Display for MatchError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoTargets => f.write_str("no target was found"),
            Self::Layout { coded } => write!(
                f,
                "the layout has {coded} targets with ids; which target is which takes {MIN_CODED} or more of them"
            ),
            Self::TooFewCoded { measured, usable, duplicates, foreign } => {
                write!(
                    f,
                    "{measured} targets were found, {} of them with ids of the layout{}; which target is which takes {MIN_CODED} \
                     or more",
                    usable.len(),
                    in_brackets(usable)
                )?;
                if !duplicates.is_empty() {
                    write!(f, "; seen more than once: {}", list(duplicates))?;
                }
                if !foreign.is_empty() {
                    write!(f, "; not on the layout: {}", list(foreign))?;
                }
                Ok(())
            }
            Self::Collinear { ids } => {
                write!(
                    f,
                    "the targets with ids {} lie on a line, all or all but one; one more beside it is needed",
                    list(ids)
                )
            }
            Self::Contradiction { ids } => write!(
                f,
                "the targets with ids {} do not lie as on the layout: no other target is where it would have to be",
                list(ids)
            ),
        }
    }
}

fn list(ids: &[u16]) -> String {
    ids.iter().map(u16::to_string).collect::<Vec<_>>().join(", ")
}

fn in_brackets(ids: &[u16]) -> String {
    if ids.is_empty() { String::new() } else { format!(" ({})", list(ids)) }
}
