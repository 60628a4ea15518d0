//! The five controls, and a container with one value for each of them.

use core::fmt;
use core::ops::{Index, IndexMut};

/// A control of the helicopter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Channel {
    /// Engine throttle.
    Throttle,
    /// Collective pitch of the main rotor.
    Collective,
    /// Longitudinal cyclic pitch.
    Longitudinal,
    /// Lateral cyclic pitch.
    Lateral,
    /// Tail rotor pitch.
    Pedal,
}

impl Channel {
    /// All five controls, in the order of [`Channels::to_array`] and of the serial packets.
    pub const ALL: [Self; 5] =
        [Self::Throttle, Self::Collective, Self::Longitudinal, Self::Lateral, Self::Pedal];

    /// Name of the control in files, which is also its field in [`Channels`].
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Throttle => "throttle",
            Self::Collective => "collective",
            Self::Longitudinal => "longitudinal",
            Self::Lateral => "lateral",
            Self::Pedal => "pedal",
        }
    }
}

impl fmt::Display for Channel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// One value of type `T` for each control. In TOML it is a table with a section for each control; a missing section has
/// the default of `T`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(default, deny_unknown_fields)
)]
pub struct Channels<T> {
    /// Engine throttle.
    pub throttle: T,
    /// Collective pitch of the main rotor.
    pub collective: T,
    /// Longitudinal cyclic pitch.
    pub longitudinal: T,
    /// Lateral cyclic pitch.
    pub lateral: T,
    /// Tail rotor pitch.
    pub pedal: T,
}

impl<T> Channels<T> {
    /// Builds the container from `value` of each channel.
    #[must_use]
    pub fn from_fn(value: impl FnMut(Channel) -> T) -> Self {
        Self::from(Channel::ALL.map(value))
    }

    /// Applies `change` to each value.
    #[must_use]
    pub fn map<U>(self, change: impl FnMut(T) -> U) -> Channels<U> {
        Channels::from(self.to_array().map(change))
    }

    /// Pairs the values of both containers by channel.
    #[must_use]
    pub fn zip<U>(self, other: Channels<U>) -> Channels<(T, U)> {
        Channels {
            throttle: (self.throttle, other.throttle),
            collective: (self.collective, other.collective),
            longitudinal: (self.longitudinal, other.longitudinal),
            lateral: (self.lateral, other.lateral),
            pedal: (self.pedal, other.pedal),
        }
    }

    /// The five values in the order of [`Channel::ALL`].
    #[must_use]
    pub fn to_array(self) -> [T; 5] {
        [self.throttle, self.collective, self.longitudinal, self.lateral, self.pedal]
    }

    /// The five values with their channels, in the order of [`Channel::ALL`].
    pub fn iter(&self) -> impl Iterator<Item = (Channel, &T)> {
        Channel::ALL.into_iter().map(|channel| (channel, &self[channel]))
    }
}

impl<T> From<[T; 5]> for Channels<T> {
    /// Builds the container from five values in the order of [`Channel::ALL`].
    fn from([throttle, collective, longitudinal, lateral, pedal]: [T; 5]) -> Self {
        Self { throttle, collective, longitudinal, lateral, pedal }
    }
}

impl<T> Index<Channel> for Channels<T> {
    type Output = T;

    fn index(&self, channel: Channel) -> &T {
        match channel {
            Channel::Throttle => &self.throttle,
            Channel::Collective => &self.collective,
            Channel::Longitudinal => &self.longitudinal,
            Channel::Lateral => &self.lateral,
            Channel::Pedal => &self.pedal,
        }
    }
}

impl<T> IndexMut<Channel> for Channels<T> {
    fn index_mut(&mut self, channel: Channel) -> &mut T {
        match channel {
            Channel::Throttle => &mut self.throttle,
            Channel::Collective => &mut self.collective,
            Channel::Longitudinal => &mut self.longitudinal,
            Channel::Lateral => &mut self.lateral,
            Channel::Pedal => &mut self.pedal,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_array_index_and_iteration_agree_on_the_order() {
        let names = Channels::from_fn(Channel::name);
        assert_eq!(names.to_array(), Channel::ALL.map(Channel::name));
        assert_eq!((names.throttle, names.pedal), ("throttle", "pedal"));
        assert!(names.iter().all(|(channel, name)| channel.name() == *name));
    }
}
