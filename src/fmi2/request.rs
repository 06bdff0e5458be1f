//! What `fmi2Instantiate` is asked for, and whether it is this FMU.

use crate::{Error, guid};
use core::ffi::{CStr, c_int};

/// `fmi2CoSimulation` of `fmi2Type`.
const CO_SIMULATION: c_int = 1;

/// Checks name, kind and GUID of an instance to be made; `hash` is that of the library's own GUID.
pub(crate) fn check(
    name: &CStr,
    kind: c_int,
    guid: Option<&CStr>,
    hash: u128,
) -> Result<(), Error> {
    if name.is_empty() {
        return Err(Error::Instantiate("instanceName is NULL or empty"));
    }
    if kind != CO_SIMULATION {
        return Err(Error::Instantiate(
            "fmuType is not fmi2CoSimulation, the only type of this FMU",
        ));
    }
    let given = guid.ok_or(Error::Instantiate("fmuGUID is NULL"))?;
    if given.to_bytes() == guid::text(hash).as_bytes() {
        Ok(())
    } else {
        Err(Error::Guid)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_one_request_that_is_for_this_fmu_is_accepted() {
        let own = c"{00000000-0000-0000-0000-00000000002a}";
        let refused = [
            (c"", 1, Some(own)),
            (c"a", 0, Some(own)),
            (c"a", 1, None),
            (c"a", 1, Some(c"{00000000-0000-0000-0000-00000000002b}")),
            (c"a", 1, Some(c"")),
        ];
        for (name, kind, guid) in refused {
            assert!(
                check(name, kind, guid, 42).is_err(),
                "{name:?} {kind} {guid:?}"
            );
        }
        assert_eq!(check(c"a", 1, Some(own), 42), Ok(()));
    }
}
