//! What can be done from menus, the keyboard and the palette.

use crate::panels::Pane;
use crate::state::State;
use crate::viewport::View;
use eframe::egui::{Key, KeyboardShortcut, Modifiers};

/// The keys that go to views.
pub(super) const DIGITS: [Key; 9] =
    [Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5, Key::Num6, Key::Num7, Key::Num8, Key::Num9];

/// The keys that bring panels up, in the order of the menu.
const PANEL_KEYS: [Key; 11] =
    [Key::F2, Key::F3, Key::F4, Key::F5, Key::F6, Key::F7, Key::F8, Key::F9, Key::F10, Key::F11, Key::F12];

const fn with_command(key: Key) -> KeyboardShortcut {
    KeyboardShortcut::new(Modifiers::COMMAND, key)
}

/// What can be done from menus, the keyboard and the palette.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Action {
    Open,
    Save,
    SaveAs,
    /// Leaves the city: cities to choose from are shown.
    Start,
    Quit,
    Undo,
    Redo,
    ResetAll,
    Build,
    Cancel,
    Fit,
    FitAll,
    /// Keeps where one looks from, by a name of its own.
    Keep,
    Why,
    Palette,
    Larger,
    Smaller,
    /// Looks from where that was kept.
    GoTo(usize),
    /// Gives the graphics device up and takes another.
    Restart,
    /// Lays panels out as at first.
    Usual,
    Show(Pane),
}

impl Action {
    /// All of them, by menu.
    pub(super) const MENUS: [(&'static str, &'static [Self]); 5] = [
        ("File", &[Self::Open, Self::Save, Self::SaveAs, Self::Start, Self::Quit]),
        ("Edit", &[Self::Undo, Self::Redo, Self::ResetAll]),
        ("View", &[Self::Fit, Self::FitAll, Self::Keep, Self::Larger, Self::Smaller, Self::Restart]),
        (
            "Panels",
            &[
                Self::Show(Pane::View(View::Map)),
                Self::Show(Pane::View(View::Model)),
                Self::Show(Pane::Presets),
                Self::Show(Pane::Parameters),
                Self::Show(Pane::Layers),
                Self::Show(Pane::Inspector),
                Self::Show(Pane::Statistics),
                Self::Show(Pane::Problems),
                Self::Show(Pane::Timeline),
                Self::Show(Pane::Console),
                Self::Show(Pane::Source),
                Self::Usual,
            ],
        ),
        ("City", &[Self::Build, Self::Cancel, Self::Why, Self::Palette]),
    ];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Open => "Open a city…",
            Self::Save => "Save changes",
            Self::SaveAs => "Save a copy of the city…",
            Self::Start => "Other cities",
            Self::Quit => "Quit",
            Self::Undo => "Undo",
            Self::Redo => "Redo",
            Self::ResetAll => "Reset all values",
            Self::Build => "Build again",
            Self::Cancel => "Give up building",
            Self::Fit => "Look at what is picked",
            Self::FitAll => "Look at the whole city",
            Self::Keep => "Keep this view",
            Self::Why => "Why is this here?",
            Self::Palette => "All that can be done…",
            Self::Larger => "Larger",
            Self::Smaller => "Smaller",
            Self::GoTo(_) => "Go to a view that was kept",
            Self::Restart => "Start graphics anew",
            Self::Usual => "Put panels back",
            Self::Show(pane) => pane.name(),
        }
    }

    pub(super) fn shortcut(self) -> Option<KeyboardShortcut> {
        Some(match self {
            Self::Open => with_command(Key::O),
            Self::Save => with_command(Key::S),
            Self::Quit => with_command(Key::Q),
            Self::SaveAs => KeyboardShortcut::new(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::S),
            Self::Undo => with_command(Key::Z),
            Self::Redo => KeyboardShortcut::new(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::Z),
            Self::Build => with_command(Key::B),
            Self::Fit => with_command(Key::F),
            Self::Keep => with_command(Key::K),
            Self::FitAll => KeyboardShortcut::new(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::F),
            Self::Why => with_command(Key::I),
            Self::Palette => KeyboardShortcut::new(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::P),
            Self::Larger => KeyboardShortcut::new(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::Plus),
            Self::Smaller => KeyboardShortcut::new(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::Minus),
            Self::GoTo(index) => with_command(*DIGITS.get(index)?),
            Self::Show(pane) => {
                let panels = Pane::PANELS.into_iter();
                let all = [View::Map, View::Model].map(Pane::View).into_iter().chain(panels);
                let (_, key) = all.zip(PANEL_KEYS).find(|(other, _)| *other == pane)?;
                KeyboardShortcut::new(Modifiers::NONE, key)
            }
            Self::ResetAll | Self::Cancel | Self::Restart | Self::Usual | Self::Start => return None,
        })
    }

    pub(super) fn all() -> impl Iterator<Item = Self> {
        Self::MENUS.into_iter().flat_map(|(_, actions)| actions.iter().copied())
    }

    pub(super) fn is_possible(self, state: &State) -> bool {
        match self {
            Self::Save => state.ready.is_some() && !state.history.is_saved(),
            Self::Undo => state.history.to_undo().is_some(),
            Self::Redo => state.history.to_redo().is_some(),
            Self::Build | Self::Start => state.city.is_some(),
            Self::FitAll | Self::SaveAs | Self::Keep => state.ready.is_some(),
            Self::ResetAll => {
                let now = state.history.now();
                now.seed.is_some() || now.values().next().is_some()
            }
            Self::Fit => state.selected.is_some(),
            Self::GoTo(index) => state.bookmarks().len() > index,
            Self::Restart => state.gpu().is_some(),
            Self::Cancel => state.under.is_some(),
            Self::Why => state.selected.is_some(),
            Self::Open | Self::Palette | Self::Larger | Self::Smaller | Self::Usual | Self::Quit | Self::Show(_) => {
                true
            }
        }
    }
}
