//! Comparison of the changes of the fixes' positions with the fixes' velocities.

use super::SetupFault;
use crate::earth::Geodetic;
use crate::gps::Fix;
use crate::scalar::Scalar;
use crate::time::Time;

/// Length of a comparison interval, s: time over which displacement and velocity are compared.
const PART_S: f64 = 4.0;
/// Smallest number of comparison intervals for a result: 80 s.
const MIN_PARTS: f32 = 20.0;
/// Number of comparison intervals after which the sums start again: 4 min. A single jump of position thus does not hide
/// later motion.
const MAX_PARTS: f32 = 60.0;
/// Smallest velocity on a horizontal axis, m/s rms, without its part that is proportional to the other axis. On the
/// down axis the limit is half of it.
const MIN_MPS: f32 = 0.5;
/// Smallest fraction of the sum of squared horizontal displacement rates that the velocity must explain.
const EXPLAINED: f32 = 0.8;
/// Smallest speed of positions, m/s rms, at which velocities of zero are wrong: errors of 4 m at both ends of a
/// comparison interval.
const UNREPORTED_MPS: f32 = 2.0;
/// Smallest number of comparison intervals for a result on the down axis. Heights scatter by metres, so more intervals
/// must agree on the sign.
const MIN_DOWN_PARTS: f32 = 40.0;
/// Smallest fraction of the sum of squared vertical displacement rates that the down velocity must explain.
const EXPLAINED_DOWN: f32 = 0.35;
/// Smallest ratio of the changes of height to those of a correct receiver if the heights are in feet or a smaller unit.
const OTHER_UNIT: f32 = 2.0;
/// Ratios of displacement rate to velocity of a correct receiver.
const SOUND: core::ops::Range<f32> = 0.6..1.6;
/// Range of the north ratio divided by the east ratio within which one wrong unit explains both.
const ALIKE: core::ops::Range<f32> = 0.75..1.33;
/// Largest antisymmetric part of the matrix from velocity to displacement rate, as a fraction of its largest element. A
/// late velocity on a circle causes such a part, a rotation.
const TURNED: f32 = 0.25;

/// Sums of products of velocity and displacement rate, north and east, (m/s)².
#[derive(Clone, Copy, Debug, PartialEq)]
struct Level {
    count: f32,
    reported: [f32; 3],
    /// Products of velocity and displacement rate: north north, north east, east north, east east.
    both: [f32; 4],
    moved: [f32; 2],
}

/// Sums of products of velocity and displacement rate, down, (m/s)².
#[derive(Clone, Copy, Debug, PartialEq)]
struct Down {
    count: f32,
    reported: f32,
    both: f32,
    moved: f32,
}

/// The current comparison interval: its first fix, and the integral of the velocity since this fix.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Part {
    start: (Time, Geodetic),
    last: Time,
    velocity: [f32; 2],
    /// Velocity down; NaN if it or the height is unknown.
    down: f32,
    /// Integral of the velocity north and east, m.
    along_m: [f32; 2],
    /// Integral of the velocity down, m.
    down_m: f32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FixMotion {
    part: Option<Part>,
    /// Sums of the horizontal axes; `None` after the result.
    level: Option<Level>,
    down: Option<Down>,
    /// Whether the horizontal velocity explains the displacements.
    is_sound: bool,
}

impl FixMotion {
    pub const NONE: Self =
        Self { part: None, level: Some(Level::NONE), down: Some(Down::NONE), is_sound: false };

    /// Whether the horizontal velocity has proven right.
    pub const fn is_sound(&self) -> bool {
        self.is_sound
    }

    /// Adds a fix. Returns each fault once.
    pub fn push(&mut self, fix: &Fix) -> Option<SetupFault> {
        if self.level.is_none() && self.down.is_none() {
            return None;
        }
        let Some(velocity) = fix.horizontal_velocity_mps else {
            self.part = None;
            return None;
        };
        let velocity = velocity.map(|component| component as f32);
        let down = fix.measured_down_mps().map_or(f32::NAN, |down| down as f32);
        let first = Part {
            start: (fix.time, fix.position),
            last: fix.time,
            velocity,
            down,
            along_m: [0.0; 2],
            down_m: 0.0,
        };
        let Some(part) = &mut self.part else {
            self.part = Some(first);
            return None;
        };
        let interval_s = fix.time - part.last;
        if !(interval_s > 0.0 && interval_s <= PART_S) {
            self.part = Some(first);
            return None;
        }
        part.add(fix.time, velocity, down);
        let over_s = fix.time - part.start.0;
        if over_s < PART_S {
            return None;
        }
        let ended = *part;
        self.part = Some(first);
        let share = (1.0 / over_s) as f32;
        let [north, east, fallen] = fix.position.displacement_from(&ended.start.1).to_array();
        let [north, east, fallen] = [north, east, fallen].map(|moved| share * moved as f32);
        let reported = ended.along_m.map(|along| share * along);
        let was_open = self.level.is_some();
        let level = Level::judge(&mut self.level, reported, [north, east], &fix.position);
        self.is_sound |= was_open && self.level.is_none() && level.is_none();
        let down = share * ended.down_m;
        level.or_else(|| Down::judge(&mut self.down, down, fallen))
    }
}

impl Part {
    fn add(&mut self, time: Time, velocity: [f32; 2], down: f32) {
        let half_s = 0.5 * (time - self.last) as f32;
        let ([north, east], [to_north, to_east]) = (self.velocity, velocity);
        let [along_north, along_east] = self.along_m;
        self.along_m =
            [along_north + half_s * (north + to_north), along_east + half_s * (east + to_east)];
        self.down_m += half_s * (self.down + down);
        (self.last, self.velocity, self.down) = (time, velocity, down);
    }
}

impl Level {
    const NONE: Self = Self { count: 0.0, reported: [0.0; 3], both: [0.0; 4], moved: [0.0; 2] };

    /// Adds a comparison interval to `sums`, and evaluates them. Returns a certain fault. A certain result, faulty or
    /// correct, removes the sums.
    fn judge(
        sums: &mut Option<Self>,
        reported: [f32; 2],
        moved: [f32; 2],
        position: &Geodetic,
    ) -> Option<SetupFault> {
        let level = sums.as_mut()?;
        level.add(reported, moved);
        if level.count < MIN_PARTS {
            return None;
        }
        let verdict = match (level.moves_unreported(), level.fit()) {
            (Some(speed_mps), _) => Verdict::Wrong(SetupFault::VelocityZero { speed_mps }),
            (None, Some(fit)) => Verdict::of(fit, position),
            (None, None) => Verdict::Unclear,
        };
        match verdict {
            Verdict::Wrong(fault) => {
                *sums = None;
                return Some(fault);
            }
            Verdict::Sound => *sums = None,
            Verdict::Unclear if level.count >= MAX_PARTS => *sums = Some(Self::NONE),
            Verdict::Unclear => {}
        }
        None
    }

    fn add(&mut self, [vn, ve]: [f32; 2], [mn, me]: [f32; 2]) {
        self.count += 1.0;
        let ([nn, ne, ee], [a, b, c, d], [n, e]) = (self.reported, self.both, self.moved);
        self.reported = [nn + vn * vn, ne + vn * ve, ee + ve * ve];
        self.both = [a + vn * mn, b + vn * me, c + ve * mn, d + ve * me];
        self.moved = [n + mn * mn, e + me * me];
    }

    /// Mean speed of the displacements, m/s rms, if every velocity is zero and they move faster than errors of
    /// positions.
    fn moves_unreported(&self) -> Option<f32> {
        let ([nn, _, ee], [north, east]) = (self.reported, self.moved);
        let speed_mps = libm::sqrtf((north + east) / self.count);
        (nn + ee == 0.0 && speed_mps > UNREPORTED_MPS).then_some(speed_mps)
    }

    /// Rows of the least-squares matrix from velocity to displacement rate. `None` without independent motion on both
    /// axes, or if the matrix explains too little of the displacements.
    fn fit(&self) -> Option<[[f32; 2]; 2]> {
        let [nn, ne, ee] = self.reported;
        let least = MIN_MPS * MIN_MPS * self.count;
        let determinant = nn * ee - ne * ne;
        if determinant <= least * nn || determinant <= least * ee {
            return None;
        }
        let solve = |north: f32, east: f32| {
            [(ee * north - ne * east) / determinant, (nn * east - ne * north) / determinant]
        };
        let [north_north, north_east, east_north, east_east] = self.both;
        let [of_north, of_east] = [solve(north_north, east_north), solve(north_east, east_east)];
        let [moved_north, moved_east] = self.moved;
        let explains = |[north, east]: [f32; 2], by_north: f32, by_east: f32, moved: f32| {
            north * by_north + east * by_east > EXPLAINED * moved
        };
        (explains(of_north, north_north, east_north, moved_north)
            && explains(of_east, north_east, east_east, moved_east))
        .then_some([of_north, of_east])
    }
}

/// Result of the evaluation of a velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Verdict {
    Sound,
    Wrong(SetupFault),
    Unclear,
}

impl Verdict {
    /// Evaluates the matrix from velocity to displacement rate, given row by row, of fixes near `position`.
    fn of([[nn, ne], [en, ee]]: [[f32; 2]; 2], position: &Geodetic) -> Self {
        let sizes = [nn, ne, en, ee].map(libm::fabsf);
        let largest = sizes.into_iter().fold(0.0, f32::max);
        let is_small = |scale: f32| libm::fabsf(scale) < 0.4 * largest;
        if 0.5 * libm::fabsf(ne - en) > TURNED * largest {
            return Self::Unclear;
        }
        if is_small(nn) && is_small(ee) && SOUND.contains(&ne) && SOUND.contains(&en) {
            return Self::Wrong(SetupFault::VelocitySwapped);
        }
        // A velocity that is half a circle late has both signs wrong.
        if !(is_small(ne) && is_small(en)) || nn < 0.0 && ee < 0.0 {
            return Self::Unclear;
        }
        if nn * ee < 0.0 {
            return Self::Wrong(SetupFault::VelocityReversed { north: nn < 0.0 });
        }
        if SOUND.contains(&nn) && SOUND.contains(&ee) {
            return Self::Sound;
        }
        // Radians in place of degrees shrink all distances, and move the position near the equator. A radian of
        // longitude is longer there than at the true latitude.
        let (to_rad, latitude_rad) = (1f64.to_radians(), position.latitude_deg());
        let is_radian = |found: f32, scale: f64| ALIKE.contains(&(found / scale as f32));
        if is_radian(nn, to_rad)
            && is_radian(ee, to_rad / latitude_rad.sincos().1)
            && libm::fabs(latitude_rad) < 1.5
        {
            return Self::Wrong(SetupFault::PositionInRadians);
        }
        let unit_mps = libm::sqrtf(nn * ee);
        if ALIKE.contains(&(nn / ee)) && !SOUND.contains(&unit_mps) {
            return Self::Wrong(SetupFault::VelocityScale { unit_mps });
        }
        Self::Unclear
    }
}

impl Down {
    const NONE: Self = Self { count: 0.0, reported: 0.0, both: 0.0, moved: 0.0 };

    /// As [`Level::judge`]. An interval of unknown velocity, NaN, is not added.
    fn judge(sums: &mut Option<Self>, reported: f32, moved: f32) -> Option<SetupFault> {
        if reported.is_nan() {
            return None;
        }
        let Self { count, reported: xx, both, moved: yy } = sums.as_mut()?;
        *count += 1.0;
        *xx += reported * reported;
        *both += reported * moved;
        *yy += moved * moved;
        if *count < MIN_DOWN_PARTS {
            return None;
        }
        let moves = *xx > 0.25 * MIN_MPS * MIN_MPS * *count;
        let explains = *both * *both > EXPLAINED_DOWN * *xx * *yy;
        if moves && explains {
            let factor = *both / *xx;
            let fault = if *both < 0.0 {
                Some(SetupFault::VelocityUp)
            } else {
                (factor > OTHER_UNIT).then_some(SetupFault::HeightScale { factor })
            };
            *sums = None;
            return fault;
        }
        if *count >= MAX_PARTS {
            *sums = Some(Self::NONE);
        }
        None
    }
}
