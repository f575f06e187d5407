//! Enums whose cases have names in texts and files.

/// Declares an enum without fields. Each case has a name; the enum gets `ALL`, `name` and
/// `from_name`, and with `numbered` also `number` and `from_number`.
///
/// ```
/// brood_brdf::named_enum! {
///     /// Side of a surface.
///     #[derive(Debug, Clone, Copy, PartialEq)]
///     pub enum Side {
///         /// Side of the normal.
///         Front => "front",
///         /// Other side.
///         Back => "back",
///     }
/// }
///
/// assert_eq!(Side::ALL.map(Side::name), ["front", "back"]);
/// assert_eq!(Side::from_name("back"), Some(Side::Back));
/// ```
#[macro_export]
macro_rules! named_enum {
    (numbered $($declaration:tt)+) => {
        $crate::named_enum! { $($declaration)+ }
        $crate::named_enum! { @numbered $($declaration)+ }
    };
    (@numbered $(#[$meta:meta])* pub enum $name:ident $cases:tt) => {
        impl $name {
            /// Position in `ALL`. Stored in files, so cases are only appended.
            #[inline]
            #[must_use]
            pub const fn number(self) -> u8 {
                self as u8
            }

            /// Returns the case with this number, or `None` if there is none.
            #[must_use]
            pub fn from_number(number: u8) -> Option<Self> {
                Self::ALL.get(usize::from(number)).copied()
            }
        }
    };
    (
        $(#[$meta:meta])*
        pub enum $name:ident { $($(#[$case_meta:meta])* $case:ident => $text:literal,)+ }
    ) => {
        $(#[$meta])*
        pub enum $name {
            $($(#[$case_meta])* $case,)+
        }

        impl $name {
            /// All cases in their order.
            pub const ALL: [Self; [$($text),+].len()] = [$(Self::$case),+];

            /// Name in texts and files.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$case => $text,)+
                }
            }

            /// Returns the case with this name, or `None` if there is none.
            #[must_use]
            pub fn from_name(name: &str) -> Option<Self> {
                Self::ALL.into_iter().find(|case| case.name() == name)
            }
        }
    };
}
