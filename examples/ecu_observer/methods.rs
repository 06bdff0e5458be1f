//! The methods that are built in, in the room of the largest of them.

use dct_driveline::Params;
use dct_driveline::observer::select::Inputs;
use dct_driveline::observer::{self, Estimate, Method, Sample, Settings};

/// `Acting`: one state of a method for every feature that is on.
macro_rules! methods {
    ($($feature:literal: $name:ident),*) => {
        /// State of the method that acts.
        enum Acting {
            $(#[cfg(feature = $feature)] $name(observer::$name),)*
        }

        impl Acting {
            /// Not started; `None` if the method was not built in.
            fn new(method: Method) -> Option<Self> {
                $(#[cfg(feature = $feature)]
                if method == Method::$name {
                    return Some(Self::$name(observer::$name::default()));
                })*
                None
            }

            fn observer(&mut self) -> &mut dyn observer::Observer {
                match self {
                    $(#[cfg(feature = $feature)] Self::$name(state) => state,)*
                }
            }
        }
    };
}

methods!(
    "paper": Paper,
    "lyapunov": Lyapunov,
    "energy": Energy,
    "kalman": Kalman,
    "calibrating": Calibrating
);

/// An observer of any method that is built in.
pub struct Chosen {
    inputs: Inputs,
    acting: Acting,
}

impl Chosen {
    /// Not started; `None` if the method was not built in.
    pub fn new(method: Method) -> Option<Self> {
        Acting::new(method).map(|acting| Self {
            inputs: Inputs::default(),
            acting,
        })
    }

    /// Starts from measurements.
    pub fn start(&mut self, p: &Params, settings: &Settings, sample: &Sample) -> Estimate {
        self.inputs
            .start(self.acting.observer(), p, settings, sample)
    }

    /// Advances by `h` [s].
    pub fn step(&mut self, p: &Params, settings: &Settings, sample: &Sample, h: f64) -> Estimate {
        self.inputs
            .step(self.acting.observer(), p, settings, sample, h)
    }
}
