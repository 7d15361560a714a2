//! Libraries of device makers, loaded at run time: without such a device none of them is needed.
//!
//! All `unsafe` of this crate is here. The code relies on the maker's documentation: it checks that the file has
//! functions with these names, but it cannot check what they do with their arguments.

pub(crate) mod dhd_calls;
pub(crate) mod hd_calls;

use std::ffi::{c_char, CStr};
use std::mem::ManuallyDrop;
use std::path::{Path, PathBuf};

use feeler_haptics::device::DeviceError;
use libloading::Library;

/// A library that may be there, and what to say if it is not.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Wanted {
    /// Of which device, for errors.
    pub device: &'static str,
    /// Names of the file on this system, the most likely first.
    pub names: &'static [&'static str],
    /// Software to install.
    pub what_to_do: &'static str,
}

/// A loaded library and the file that it is. It is never unloaded: its own threads may still be running in it.
pub(crate) struct Loaded {
    library: ManuallyDrop<Library>,
    file: PathBuf,
    wanted: Wanted,
}

impl Wanted {
    fn not_found(&self, why: String) -> DeviceError {
        DeviceError::NotFound { device: self.device.to_string(), why: format!("{why}; {}", self.what_to_do) }
    }

    /// Loads the library from a file, or where the system looks for the names. Errors with the files that were tried.
    pub fn load(&self, file: Option<&Path>) -> Result<Loaded, DeviceError> {
        let files: Vec<PathBuf> = match file {
            Some(file) => vec![file.to_path_buf()],
            None => self.names.iter().map(PathBuf::from).collect(),
        };
        let mut tried = vec![];
        for file in files {
            // SAFETY: loading runs the initialisers of the file. It is the maker's library by its name, or the file that the user named.
            match unsafe { Library::new(&file) } {
                Ok(library) => return Ok(Loaded { library: ManuallyDrop::new(library), file, wanted: *self }),
                Err(error) => tried.push(format!("{} ({error})", file.display())),
            }
        }
        Err(self.not_found(format!("its library was not found: {}", tried.join(", "))))
    }
}

impl Loaded {
    /// A function of the library. Errors where it has none of that name.
    ///
    /// # Safety
    ///
    /// `F` is the type of a pointer to a function as the maker documents it.
    unsafe fn function<F: Copy>(&self, name: &str) -> Result<F, DeviceError> {
        // SAFETY: by the caller's promise, the symbol is a function of this type; it stays, for the library is never unloaded.
        match unsafe { self.library.get::<F>(name) } {
            Ok(function) => Ok(*function),
            Err(_) => Err(self.wanted.not_found(format!(
                "{} has no function {name}, so it is another library or too old",
                self.file.display()
            ))),
        }
    }
}

/// A struct of all functions that a driver calls, each resolved when the library is loaded.
macro_rules! functions {
    ($calls:ident { $($name:ident($($argument:ty),*) $(-> $result:ty)?;)* }) => {
        #[allow(non_snake_case, reason = "the maker's names")]
        struct $calls {
            $($name: unsafe extern "system" fn($($argument),*) $(-> $result)?,)*
        }

        impl $calls {
            fn of(library: &crate::vendor_library::Loaded) -> Result<$calls, feeler_haptics::device::DeviceError> {
                Ok($calls {
                    // SAFETY: the types are those of the maker's header.
                    $($name: unsafe { library.function(stringify!($name)) }?,)*
                })
            }
        }
    };
}
use functions;

/// A text that a library keeps, or nothing for a null pointer.
///
/// # Safety
///
/// The pointer is null, or to characters that end with a zero and stay until this returns.
unsafe fn text(characters: *const c_char) -> String {
    if characters.is_null() {
        return String::new();
    }
    // SAFETY: by the caller's promise.
    unsafe { CStr::from_ptr(characters) }.to_string_lossy().trim().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    const WANTED: Wanted =
        Wanted { device: "test", names: &["libfeeler-nowhere.so", "libfeeler-nowhere.so.1"], what_to_do: "install it" };

    #[test]
    fn a_missing_library_is_said_with_the_files_and_what_to_do() {
        let error = WANTED.load(None).err().unwrap().to_string();
        assert!(WANTED.names.iter().all(|name| error.contains(name)) && error.contains("install it"), "{error}");
        let error = WANTED.load(Some(Path::new("/nowhere/x.so"))).err().unwrap().to_string();
        assert!(error.contains("/nowhere/x.so") && !error.contains("libfeeler"), "{error}");
    }
}
