//! The ring of segments around a coded target.

use super::outline::Outline;
use crate::layout::CodeName;
use anyhow::{Context, Result};
use concentric::code;
use glam::DVec2;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// A ring of segments in the target's ink, from [`code::INNER`] to [`code::OUTER`] of its outer radius.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CodeRing {
    /// The code.
    pub code: CodeName,
    /// The id.
    pub id: u16,
    /// Direction on the plane in which the id's word begins, from +x towards +y, degrees.
    pub angle: f64,
}

impl CodeRing {
    /// The ring of this id, which begins at +x.
    pub fn new(code: CodeName, id: u16) -> Self {
        Self { code, id, angle: 0.0 }
    }

    /// Which segments are set, from the first one on.
    ///
    /// # Errors
    /// An id that the code does not have.
    pub fn segments(&self) -> Result<Vec<bool>> {
        let code = self.code.code();
        let word = code.word(self.id).filter(|_| code.has(self.id));
        let word = word.with_context(|| format!("id {} is not in the code {}", self.id, self.code.name()))?;
        Ok((0..code.segments()).rev().map(|bit| word >> bit & 1 == 1).collect())
    }

    /// The arcs of ink, each from a direction on by an angle, radians: segments side by side are one.
    ///
    /// # Errors
    /// As [`segments`](Self::segments).
    pub fn arcs(&self) -> Result<Vec<[f64; 2]>> {
        let segments = self.segments()?;
        let width = TAU / segments.len() as f64;
        // No word has all segments set.
        let gap = segments.iter().position(|set| !set).unwrap_or(0);
        let turned: Vec<bool> = (0..segments.len()).map(|i| segments[(gap + i) % segments.len()]).collect();
        let mut arcs: Vec<[f64; 2]> = Vec::new();
        for (i, set) in turned.iter().enumerate() {
            match arcs.last_mut() {
                Some(arc) if *set && turned[i - 1] => arc[1] += width,
                _ if *set => arcs.push([self.angle.to_radians() + (gap + i) as f64 * width, width]),
                _ => (),
            }
        }
        Ok(arcs)
    }

    /// The outlines around a target of this outer radius.
    ///
    /// # Errors
    /// As [`segments`](Self::segments).
    pub fn outlines(&self, centre: DVec2, radius: f64) -> Result<Vec<Outline>> {
        let (outer, inner) = (f64::from(code::OUTER), f64::from(code::INNER));
        let outline = |[start, sweep]: [f64; 2]| {
            let gap = TAU - sweep;
            Outline::open_ring(outer, inner, gap).placed(centre, start - gap / 2.0, radius)
        };
        Ok(self.arcs()?.into_iter().map(outline).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arcs_join_segments_side_by_side() {
        // 00000011111111, 00001100001111, 00100100110011.
        let width = 360.0 / 14.0;
        for (id, expected) in [
            (32, vec![(6.0, 8.0)]),
            (123, vec![(4.0, 2.0), (10.0, 4.0)]),
            (336, vec![(2.0, 1.0), (5.0, 1.0), (8.0, 2.0), (12.0, 2.0)]),
        ] {
            let ring = CodeRing { angle: 10.0, ..CodeRing::new(CodeName::Five, id) };
            let arcs = ring.arcs().unwrap();
            assert_eq!(arcs.len(), expected.len());
            for ([start, sweep], (first, count)) in arcs.into_iter().zip(expected) {
                assert!((start.to_degrees() - 10.0 - first * width).abs() < 1e-9, "{id} {start}");
                assert!((sweep.to_degrees() - count * width).abs() < 1e-9, "{id} {sweep}");
            }
        }
        assert!(CodeRing::new(CodeName::Five, 33).segments().is_err());
    }
}
