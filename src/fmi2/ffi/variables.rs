//! Variables at the C boundary: typed access, derivatives, the status of the last step.

use super::pointer::{place, slice, slice_mut, usable};
use super::real::Other;
use super::{Component, Library, Status, real};
use crate::handle::Entered;
use crate::row::names;
use crate::value::Value;
use crate::{Call, Error, Instance, Model};
use core::ffi::{c_int, c_void};
use core::slice::{from_raw_parts, from_raw_parts_mut};

impl<M: Model> Library<M> {
    /// `fmi2GetReal`: what is plain at once, everything else as for other types. Where it fails, all values are NaN.
    #[inline(always)]
    pub unsafe fn get_reals(
        &self,
        component: *mut c_void,
        references: *const u32,
        count: usize,
        values: *mut f64,
    ) -> Status {
        let enter = || self.instances.enter_first(component.addr());
        // SAFETY: `count` references and as many places for values (Arrays, 2.1.7).
        if unsafe { Self::get_plainly(enter, Instance::get_plainly, references, count, values) } {
            return Status::Ok;
        }
        // SAFETY: the same.
        unsafe { Self::get_carefully(component, references, count, values, self) }
    }

    /// `fmi2SetReal`: what is plain at once, everything else as for other types.
    #[inline(always)]
    pub unsafe fn set_reals(
        &self,
        component: *mut c_void,
        references: *const u32,
        count: usize,
        values: *const f64,
    ) -> Status {
        // SAFETY: `count` references and as many values (Arrays, 2.1.7).
        if unsafe { self.set_plainly(component, references, count, values) } {
            return Status::Ok;
        }
        // SAFETY: the same.
        unsafe { Self::set_carefully(component, references, count, values, self) }
    }

    #[inline(always)]
    unsafe fn get_plainly<'a, A>(
        enter: impl FnOnce() -> Option<Entered<'a, Component<M>>>,
        get: impl FnOnce(&mut Instance<M>, &[u32], &mut [A]) -> bool,
        references: *const u32,
        count: usize,
        values: *mut A,
    ) -> bool {
        Self::plainly(enter(), |instance| {
            if count.wrapping_sub(1) >= const { names::<M>() } || !usable(references, values) {
                return false;
            }
            // SAFETY: usable, not empty, of that length (Arrays, 2.1.7), and two arrays (Stillness).
            let (references, values) = unsafe {
                (
                    from_raw_parts(references, count),
                    from_raw_parts_mut(values, count),
                )
            };
            get(instance, references, values)
        })
    }

    #[inline(always)]
    unsafe fn set_plainly(
        &self,
        component: *mut c_void,
        references: *const u32,
        count: usize,
        values: *const f64,
    ) -> bool {
        Self::plainly(self.instances.enter_first(component.addr()), |instance| {
            if count.wrapping_sub(1) >= real::most::<M>() || !usable(references, values) {
                return false;
            }
            // SAFETY: usable, not empty, of that length (Arrays, 2.1.7), and not written to meanwhile (Stillness).
            let (references, values) = unsafe {
                (
                    from_raw_parts(references, count),
                    from_raw_parts(values, count),
                )
            };
            instance.set_plainly(references, values)
        })
    }

    /// [`Self::get`] of Reals, from wherever the instance is; where that fails, all values are NaN. The arguments lie
    /// where those of `fmi2GetReal` do.
    #[cold]
    #[inline(never)]
    unsafe extern "C" fn get_carefully(
        component: *mut c_void,
        references: *const u32,
        count: usize,
        values: *mut f64,
        library: &Self,
    ) -> Status {
        let enter = || library.instances.enter(component.addr());
        // A function of its own: used twice, that of `get_reals` would no longer be part of it.
        let get = |instance: &mut Instance<M>, references: &[u32], values: &mut [f64]| {
            instance.get_plainly(references, values)
        };
        // SAFETY: `count` references and as many places for values (Arrays, 2.1.7).
        if unsafe { Self::get_plainly(enter, get, references, count, values) } {
            return Status::Ok;
        }
        // SAFETY: the same.
        let status = unsafe { library.get::<f64, f64>(component, references, count, values) };
        if status != Status::Ok && plausible::<M>(count).is_ok() {
            // SAFETY: the same.
            if let Ok(values) = unsafe { slice_mut("value", values, count) } {
                values.fill(f64::NAN);
            }
        }
        status
    }

    /// [`Self::set`] of Reals, from wherever the instance is. The arguments lie where those of
    /// `fmi2SetReal` do.
    #[cold]
    #[inline(never)]
    unsafe extern "C" fn set_carefully(
        component: *mut c_void,
        references: *const u32,
        count: usize,
        values: *const f64,
        library: &Self,
    ) -> Status {
        library.enter(component, Call::SetReal, |instance, _| {
            plausible::<M>(count)?;
            // SAFETY: `count` references (Arrays, 2.1.7).
            let references = unsafe { slice("vr", references, count)? };
            // SAFETY: `count` values (Arrays, 2.1.7).
            let values = unsafe { slice("value", values, count)? };
            let few = (1..=real::most::<M>()).contains(&count);
            if few && instance.set_plainly(references, values) {
                return Ok(());
            }
            instance.set(references, values.iter().copied())
        })
    }

    /// `fmi2GetInteger` and, with `A` an int, `fmi2GetBoolean`: what is plain at once.
    #[inline(always)]
    pub unsafe fn get_others<T: Other, A: From<T>>(
        &self,
        component: *mut c_void,
        references: *const u32,
        count: usize,
        values: *mut A,
    ) -> Status {
        let enter = || self.instances.enter_first(component.addr());
        let get = Instance::get_others_plainly::<T, A>;
        // SAFETY: `count` references and as many places for values (Arrays, 2.1.7).
        if unsafe { Self::get_plainly(enter, get, references, count, values) } {
            return Status::Ok;
        }
        // SAFETY: the same.
        unsafe { self.get::<T, A>(component, references, count, values) }
    }

    /// [`Self::get_reals`] and [`Self::get_others`] with a second look.
    #[inline(never)]
    unsafe fn get<T: Value, A: From<T>>(
        &self,
        component: *mut c_void,
        references: *const u32,
        count: usize,
        values: *mut A,
    ) -> Status {
        self.enter(component, T::GET, |instance, log| {
            plausible::<M>(count)?;
            // SAFETY: `count` references (Arrays, 2.1.7).
            let references = unsafe { slice("vr", references, count)? };
            // SAFETY: room for `count` values (Arrays, 2.1.7) that lies apart (Stillness).
            let values = unsafe { slice_mut("value", values, count)? };
            let read = instance.get::<T>(references, log)?;
            for (to, from) in values.iter_mut().zip(read) {
                *to = from.into();
            }
            Ok(())
        })
    }

    /// `fmi2SetInteger` and, with `A` an int, `fmi2SetBoolean`.
    #[inline(never)]
    pub unsafe fn set<T: Value, A: Copy>(
        &self,
        component: *mut c_void,
        references: *const u32,
        count: usize,
        values: *const A,
        convert: fn(A) -> T,
    ) -> Status {
        self.enter(component, T::SET, |instance, _| {
            plausible::<M>(count)?;
            // SAFETY: `count` references (Arrays, 2.1.7).
            let references = unsafe { slice("vr", references, count)? };
            // SAFETY: `count` values (Arrays, 2.1.7).
            let values = unsafe { slice("value", values, count)? };
            instance.set(references, values.iter().map(|value| convert(*value)))
        })
    }

    /// `fmi2SetRealInputDerivatives`.
    pub unsafe fn set_input_derivatives(
        &self,
        component: *mut c_void,
        references: *const u32,
        count: usize,
        orders: *const c_int,
        values: *const f64,
    ) -> Status {
        self.enter(component, Call::SetRealInputDerivatives, |instance, _| {
            plausible::<M>(count)?;
            // SAFETY: `count` of both (Arrays, 4.2.1).
            let (references, orders) = unsafe { derivatives(references, orders, count)? };
            // SAFETY: `count` values (Arrays, 4.2.1).
            let values = unsafe { slice("value", values, count)? };
            instance.set_input_derivatives(references, orders, values)
        })
    }

    /// `fmi2GetRealOutputDerivatives`.
    pub unsafe fn get_output_derivatives(
        &self,
        component: *mut c_void,
        references: *const u32,
        count: usize,
        orders: *const c_int,
        values: *mut f64,
    ) -> Status {
        self.enter(
            component,
            Call::GetRealOutputDerivatives,
            |instance, log| {
                plausible::<M>(count)?;
                // SAFETY: `count` of both (Arrays, 4.2.1).
                let (references, orders) = unsafe { derivatives(references, orders, count)? };
                // SAFETY: room for `count` values (Arrays, 4.2.1) that lies apart (Stillness).
                let values = unsafe { slice_mut("value", values, count)? };
                let read = instance.output_derivatives(references, orders, log)?;
                for (to, from) in values.iter_mut().zip(read) {
                    *to = from;
                }
                Ok(())
            },
        )
    }

    /// `fmi2GetDirectionalDerivative`; `counts` of unknowns and knowns.
    pub unsafe fn directional_derivative(
        &self,
        component: *mut c_void,
        (unknowns, knowns): (*const u32, *const u32),
        counts: [usize; 2],
        direction: *const f64,
        derivatives: *mut f64,
    ) -> Status {
        self.enter(
            component,
            Call::GetDirectionalDerivative,
            |instance, log| {
                counts.into_iter().try_for_each(plausible::<M>)?;
                let [outputs, inputs] = counts;
                // SAFETY: `outputs` references (Arrays, 2.1.9).
                let unknowns = unsafe { slice("vUnknown_ref", unknowns, outputs)? };
                // SAFETY: `inputs` references (Arrays, 2.1.9).
                let knowns = unsafe { slice("vKnown_ref", knowns, inputs)? };
                // SAFETY: one value for each known (Arrays, 2.1.9).
                let direction = unsafe { slice("dvKnown", direction, inputs)? };
                // SAFETY: room for one value for each unknown (Arrays, 2.1.9) that lies apart (Stillness).
                let derivatives = unsafe { slice_mut("dvUnknown", derivatives, outputs)? };
                let references = (unknowns, knowns);
                instance.directional_derivative(references, direction, derivatives, log)
            },
        )
    }

    /// `fmi2GetRealStatus(fmi2LastSuccessfulTime)`; the other kinds are not known.
    pub unsafe fn real_status(
        &self,
        component: *mut c_void,
        kind: c_int,
        value: *mut f64,
    ) -> Status {
        self.enter(component, Call::GetRealStatus, |instance, _| {
            let time = instance.last_successful_time(kind)?;
            // SAFETY: room for one value (Places, 4.2.3).
            *unsafe { place("value", value)? } = time;
            Ok(())
        })
    }
}

/// Value references and orders of derivatives.
///
/// # Safety
/// There are `count` of both, or NULL is in their place.
unsafe fn derivatives<'a>(
    references: *const u32,
    orders: *const c_int,
    count: usize,
) -> Result<(&'a [u32], &'a [c_int]), Error> {
    // SAFETY: this function's condition: `count` of both (Arrays, 4.2.1).
    unsafe {
        Ok((
            slice("vr", references, count)?,
            slice("order", orders, count)?,
        ))
    }
}

/// Refuses counts that no call without repetition of a name can have.
pub(super) fn plausible<M: Model>(count: usize) -> Result<(), Error> {
    if count > const { names::<M>() } {
        Err(Error::Count(count))
    } else {
        Ok(())
    }
}
