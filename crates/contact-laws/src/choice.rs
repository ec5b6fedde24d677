//! Choices that users make by name: history rules, shapes of the slip limit and so on.
//!
//! Each is an enum whose rows are written once, with the macro `choices!`. The names in files, the constants of the C
//! interface, the names in Python and the texts of refusals follow from these rows.

/// An enum that users choose from by name, or from C by number.
pub trait Choice: Copy + PartialEq + 'static {
    /// What is chosen, as in the constants of C: `HISTORY` in `CL_HISTORY_PAPER`.
    const SUBJECT: &'static str;
    /// The same for a reader: `History rule`.
    const TITLE: &'static str;
    /// All there are. The first one is the default.
    const ALL: &'static [Self];

    /// Its name in files and in Python.
    fn name(self) -> &'static str;

    /// Its number in C. It never changes.
    fn number(self) -> i32;

    /// What it is, in one sentence.
    fn summary(self) -> &'static str;

    /// What has this name.
    fn by_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|value| value.name() == name)
    }

    /// What has this number.
    fn by_number(number: i32) -> Option<Self> {
        Self::ALL.iter().copied().find(|value| value.number() == number)
    }
}

/// An enum with its rows: variant, name, number in C, summary. `SUBJECT "Title"` are those of [`Choice`].
macro_rules! choices {
    (
        $(#[$about:meta])*
        pub enum $Choice:ident, $subject:literal, $title:literal {
            $( $(#[$more:meta])* $Variant:ident = $name:literal, $number:literal, $summary:literal; )+
        }
    ) => {
        $(#[$about])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        pub enum $Choice {
            $(
                #[doc = $summary]
                $(#[$more])*
                #[cfg_attr(feature = "serde", serde(rename = $name))]
                $Variant,
            )+
        }

        impl $crate::choice::Choice for $Choice {
            const SUBJECT: &'static str = $subject;
            const TITLE: &'static str = $title;
            const ALL: &'static [Self] = &[$(Self::$Variant,)+];

            fn name(self) -> &'static str {
                match self {
                    $(Self::$Variant => $name,)+
                }
            }

            fn number(self) -> i32 {
                match self {
                    $(Self::$Variant => $number,)+
                }
            }

            fn summary(self) -> &'static str {
                match self {
                    $(Self::$Variant => $summary,)+
                }
            }
        }

        impl Default for $Choice {
            fn default() -> Self {
                <Self as $crate::choice::Choice>::ALL[0]
            }
        }
    };
}
pub(crate) use choices;
