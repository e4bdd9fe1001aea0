//! Thresholds. Lengths in px, levels in grey levels of 0..=255.

/// Smallest local contrast that counts as an edge, grey levels: below it 8-bit quantisation and shading
/// make contours of their own.
pub const MIN_CONTRAST: u8 = 10;
/// The same in halves of the noise figure (the range that the samples of one cell in eight stay below, about 1.9 sigma): 10
/// sigma. In a frame of a million pixels the widest of all windows of pure noise spans 9.
pub const CONTRAST_TO_NOISE: u32 = 11;
/// Smallest bounding box, px: a semi-axis of 2.5 px is the least at which an ellipse can be told from a square.
pub const MIN_EXTENT: u16 = 5;
/// Smallest semi-minor axis of the outer circle, px: below it the edges blur into each other.
pub const MIN_OUTER_SEMI_AXIS: f32 = 4.5;
/// Area over that of the ellipse with the same second moments, minus one: tolerance for a large outline.
/// A square has -0.045.
pub const AREA_TOLERANCE: f32 = 0.02;
/// What the pixel grid adds to it, times the semi-minor axis, px.
pub const AREA_TOLERANCE_GRID: f32 = 0.15;
/// Largest perspective, sin(tilt) x radius / distance of the target: 0.3 leaves room for a 60 mm circle at 200 mm seen
/// at 80 degrees.
pub const MAX_PERSPECTIVE: f32 = 0.3;
/// Shortest focal length, in widths of the frame: a field of view of 127 degrees. It bounds the perspective of small
/// circles, because radius / distance = semi-major axis / focal length.
pub const MIN_FOCAL_LENGTH: f32 = 0.25;
/// What the pixel grid adds to the distance of two centres found from whole pixels, px.
pub const GRID_CENTRE: f32 = 0.5;
/// What remains of that between fitted ellipses (noise, print, distortion), px.
pub const FITTED_CENTRE: f32 = 0.2;
/// Widest open outline, in widths of a closed one inside it, that the closed one waits for: the smallest ratio, 0.1,
/// with room for perspective.
pub const MAX_GROWTH: i32 = 12;
/// Largest relative split of the two roots of the conic pencil that are equal for concentric circles.
pub const MAX_SPLIT: f32 = 0.06;
/// What one px of residual adds to it, times the inner semi-minor axis, px.
pub const SPLIT_PER_RESIDUAL: f32 = 4.0;
/// Ratio of the areas above which the pencil has no single root.
pub const PENCIL_AREA_RATIO: f32 = 0.8;
/// Ratio of the radii above which two circles can be the two sides of a line.
pub const LINE_RATIO: f32 = 0.7;
/// A circle whose centre is off the line of the others by more than this many standard deviations ...
pub const MARK_SIGMAS: f32 = 5.0;
/// ... plus this, px (print), is a mark.
pub const MARK_OFFSET: f32 = 0.05;
/// Relative tolerance of a measured ratio against the wanted one. Radii of a blurred, unevenly lit or
/// gamma-distorted print are displaced by up to 0.2 px.
pub const RATIO_TOLERANCE: f32 = 0.04;
/// What an edge displacement adds to it, times the inner semi-minor axis, px.
pub const RATIO_TOLERANCE_EDGE: f32 = 0.25;
/// Relative tolerance for a ring in whose gap there is paper: with other ratios it is a letter C.
pub const OPEN_RATIO: f32 = 0.03;
/// A ratio that comes this near to that limit is not taken for the wanted one.
pub const RATIO_DISTRUST: f32 = 0.02;
/// The same for the arcs of a ring of segments, whose ellipses are guesses.
pub const CODE_RATIO: f32 = 0.06;
/// A mark in the middle is not a circle of the target: smallest ratio accepted where ratios are measured.
pub const MIN_MEASURED_RATIO: f32 = 0.18;
/// Smallest semi-minor axis of an inner circle, px.
pub const MIN_INNER_SEMI_AXIS: f32 = 2.5;
/// Largest RMS residual of an ellipse, px, for a small one ...
pub const MAX_RMS: f32 = 0.22;
/// ... and what each px of semi-minor axis adds (lens distortion, print).
pub const MAX_RMS_PER_AXIS: f32 = 0.004;
/// The same for a broken circle, as a share of that: where less is seen, less is borne.
pub const PARTIAL_RMS: f32 = 0.5;
/// Largest share of the outline without edge points, in sectors of 32: above it the ellipse is a guess.
pub const MAX_GAP: u32 = 16;
/// The same where the circles are fitted together.
pub const MAX_GAP_TOGETHER: u32 = 20;
/// Share that sets the flag `OCCLUDED`.
pub const FLAG_GAP: u32 = 3;
/// Residual of an ellipse above which the flag `RESIDUAL` is set, px, if there is no noise: what a good print and the
/// rounding to grey levels leave, with room.
pub const FLAG_RESIDUAL: f32 = 0.05;
/// Variance of the edge points that noise explains, times this, is allowed on top.
pub const FLAG_RESIDUAL_NOISE: f32 = 4.0;
/// Below this contrast the flag `LOW_CONTRAST` is set, grey levels.
pub const FLAG_CONTRAST: f32 = 40.0;
/// Below this inner semi-minor axis or gap the flag `SMALL` is set, px.
pub const FLAG_SMALL: f32 = 4.0;
/// Most searches for arcs in a frame. What is broken beyond that is refused unsearched, and counted.
pub const MAX_SEARCHES: u32 = 64;
/// The same in a small frame: a few, and one for so many px.
pub const FEW_SEARCHES: u32 = 16;
pub const PX_PER_SEARCH: u32 = 4096;
/// Fewest sectors of 32 in which a broken circle is seen where nothing else is known of it ...
pub const MIN_SEEN: u32 = 8;
/// ... and where one concentric with it is known.
pub const MIN_SEEN_AROUND: u32 = 5;
/// Smallest share of the edge points of an ellipse, as far as its longest gap leaves them, that must be there and on it.
pub const MIN_POINTS_SHARE: f32 = 0.5;
/// The same where there is no gap: something along the rim has the others, and some of those that are left.
pub const MIN_POINTS_SHARE_WHOLE: f32 = 0.7;
/// Smallest semi-major axis of a broken outer circle, px: in a smaller one it cannot be seen whether the gap is one of the
/// print.
pub const MIN_PARTIAL_SEMI_AXIS: f32 = 8.0;
/// Largest ratio of the semi-axes of a broken circle: an arc of a steeper one cannot be told from a line.
pub const MAX_ASPECT: f32 = 6.0;
/// What the search adds to the distance of two centres where one of them is of a broken circle, px.
pub const ARC_CENTRE: f32 = 2.0;
/// An outline cut by the frame may have one in this many of all crossings that fit.
pub const CUT_SHARE: usize = 8;
/// Residual of a target's levels, in standard deviations of the samples across its edges, above which something else than the
/// print has a part in them.
pub const DISTURBED: f32 = 2.5;
/// Largest difference of a sample from the profile of its edge, as a share of the contrast (curved response, gradients), ...
pub const MISFIT: f32 = 0.06;
/// ... plus this many standard deviations of the noise: more is something else in front of the edge.
pub const MISFIT_SIGMAS: f32 = 4.0;
/// Largest deviation of the light beside an edge from that around the rest of the circle, as a share of the contrast: more is
/// glare or a shadow, which moves the edge by 2.5 times its blur for the whole of the contrast.
pub const UNEVEN: f32 = 0.02;
/// Room for the noise in that, standard deviations of a sector's mean.
pub const UNEVEN_SIGMAS: f32 = 4.0;
/// Largest noise of a target's samples, as a share of the contrast.
pub const MOST_NOISE: f32 = 0.125;
/// Variance of a target of which arcs are hidden, in units of what its edge points tell: what hides them reaches into some
/// that are left.
pub const COVERED_VARIANCE: f32 = 2.25;
/// The same where glare, scratches or dirt lie on a target of which all is seen: they move edge points all together, which
/// their scatter does not show.
pub const SPOILED_VARIANCE: f32 = 5.5;
/// Variance of a target of which all is seen, measured circle by circle, in units of what its edge points tell: they share
/// the levels and the blur that they were placed with.
pub const ALONE_VARIANCE: f32 = 1.1;
/// Mean squared residual of a target's ellipses under the camera, in units of their variance, above which they
/// contradict it: chance alone does that to one target with two circles in 10,000, even where the noise is 10 % above
/// what the residuals tell.
pub const CAMERA_MISFIT: f32 = 7.0;
/// The same above which the covariance grows with it: chance alone exceeds it in 5 %.
pub const CAMERA_INFLATION: f32 = 2.4;
/// Poles of a target farther apart than this many standard deviations do not belong to the plane of the others.
pub const PLANE_SIGMAS: f32 = 5.0;
/// Mean squared distance of the poles, in units of their variance, above which there is no plane: 5 standard deviations.
pub const PLANE_MISFIT: f32 = 25.0;
/// Residuals above this many RMS are outliers.
pub const OUTLIER: f32 = 3.5;
