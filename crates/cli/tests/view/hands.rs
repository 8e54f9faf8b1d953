//! Mouse and keyboard as the desktop has them, not as scripts pretend: through the X server into the window.

use std::time::Duration;

use x11rb::connection::Connection;
use x11rb::protocol::xproto::{
    BUTTON_PRESS_EVENT, BUTTON_RELEASE_EVENT, ConnectionExt, InputFocus, KEY_PRESS_EVENT, KEY_RELEASE_EVENT,
    MOTION_NOTIFY_EVENT, Window,
};
use x11rb::protocol::xtest::ConnectionExt as _;
use x11rb::rust_connection::RustConnection;

use crate::view::SCENE;
use crate::view::desk::{Desk, Screen, assert_good, can_draw};

const CONTROL: u32 = 0xffe3;
const DELETE: u32 = 0xffff;
const LEFT: u8 = 1;

#[test]
fn real_hands_select_delete_and_save() {
    let Some(screen) = Screen::new().filter(|_| can_draw()) else { return };
    let desk = Desk::new(SCENE);
    // The script only keeps the window open, and says when it is there.
    let script =
        "wait 1 samples\nscreenshot ready.png\nwait 1 frames\nwait 1 saves\nscreenshot after.png\nwait 2 frames";
    let mut run = desk.start(script, &["--device", "cpu", "--size", "640x400"], Some(&screen));
    run.wait_for(&desk.path("ready.png"));

    let hands = Hands::new(screen.name());
    // The clay sphere is in the middle of what the panel leaves of the window.
    hands.click(160, 200);
    hands.key(DELETE);
    hands.chord(CONTROL, u32::from(b's'));
    assert_good(&run.finish());
    desk.assert_valid();
    let without = SCENE.replace("[[shapes]]\nmaterial = \"clay\"\nsphere = { center = [0, 1, 0], radius = 1 }\n", "");
    assert_eq!(desk.read("scene.toml"), without);
}

#[test]
#[cfg(target_os = "linux")]
fn a_window_in_which_nothing_happens_takes_no_time_of_the_processor() {
    const SPACE: u32 = 0x20;
    let Some(screen) = Screen::new().filter(|_| can_draw()) else { return };
    let desk = Desk::new(SCENE);
    let run = desk.open(&["--device", "cpu", "--size", "500x300"], Some(&screen));
    // Seconds of processor time, in hundredths, as Linux counts them.
    let used = || {
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", run.id())).expect("the program runs");
        let after_name = stat.rsplit(')').next().unwrap_or_default().split_whitespace().collect::<Vec<_>>();
        let field = |place: usize| after_name[place].parse::<u64>().expect("a number");
        field(11) + field(12)
    };
    let over = |time: Duration| {
        let before = used();
        std::thread::sleep(time);
        used() - before
    };
    std::thread::sleep(Duration::from_secs(4));
    let hands = Hands::new(screen.name());
    assert!(over(Duration::from_secs(2)) > 50, "it samples for ever");
    hands.key(SPACE);
    std::thread::sleep(Duration::from_secs(1));
    let paused = over(Duration::from_secs(2));
    run.kill();
    assert!(paused < 10, "{paused} hundredths of a second while it is paused");
}

/// Mouse and keyboard of a user at a desktop, on the only window of a screen.
struct Hands {
    server: RustConnection,
    root: Window,
    corner: [i16; 2],
}

impl Hands {
    fn new(display: &str) -> Self {
        let (server, screen) = x11rb::connect(Some(display)).expect("the X server");
        let root = server.setup().roots[screen].root;
        let windows = server.query_tree(root).expect("a request").reply().expect("the windows").children;
        let size = |window: &Window| {
            let geometry = server.get_geometry(*window).expect("a request").reply().expect("a window");
            (u32::from(geometry.width) * u32::from(geometry.height), [geometry.x, geometry.y])
        };
        // The viewer's window is the largest, for toolkits make small ones of their own.
        let window = windows.into_iter().max_by_key(|window| size(window).0).expect("the viewer's window");
        let (_, corner) = size(&window);
        // There is no window manager to do it.
        server.set_input_focus(InputFocus::PARENT, window, x11rb::CURRENT_TIME).expect("a request");
        let hands = Self { server, root, corner };
        hands.rest();
        hands
    }

    fn click(&self, x: i16, y: i16) {
        self.fake(MOTION_NOTIFY_EVENT, 0, [self.corner[0] + x, self.corner[1] + y]);
        self.fake(BUTTON_PRESS_EVENT, LEFT, [0, 0]);
        self.fake(BUTTON_RELEASE_EVENT, LEFT, [0, 0]);
    }

    fn key(&self, symbol: u32) {
        let code = self.code(symbol);
        self.fake(KEY_PRESS_EVENT, code, [0, 0]);
        self.fake(KEY_RELEASE_EVENT, code, [0, 0]);
    }

    fn chord(&self, held: u32, symbol: u32) {
        let code = self.code(held);
        self.fake(KEY_PRESS_EVENT, code, [0, 0]);
        self.key(symbol);
        self.fake(KEY_RELEASE_EVENT, code, [0, 0]);
    }

    fn fake(&self, kind: u8, detail: u8, [x, y]: [i16; 2]) {
        self.server.xtest_fake_input(kind, detail, x11rb::CURRENT_TIME, self.root, x, y, 0).expect("a request");
        self.rest();
    }

    /// Waits long enough for the window to draw a frame or two in between, as it is between the movements of a hand.
    fn rest(&self) {
        self.server.flush().expect("the X server listens");
        std::thread::sleep(Duration::from_millis(250));
    }

    /// The key that has this symbol.
    fn code(&self, symbol: u32) -> u8 {
        let (first, last) = (self.server.setup().min_keycode, self.server.setup().max_keycode);
        let map =
            self.server.get_keyboard_mapping(first, last - first + 1).expect("a request").reply().expect("the keys");
        let width = usize::from(map.keysyms_per_keycode);
        let place = map.keysyms.iter().position(|known| *known == symbol).expect("a key of that name");
        first + (place / width) as u8
    }
}
