//! The page in a real browser: select channels, move, zoom, pause, continue, record, retrieve, seek, export, mark.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use crate::common::browser::{Browser, chromium};
use crate::common::{cycle, serve};
use hovernav_ground::link::{SharedStation, lock};
use hovernav_ground::station::now_s;

/// A vehicle at 33 Hz that has flown for longer than the window of 60 s, until dropped.
struct Vehicle {
    stop: Arc<AtomicBool>,
    silent: Arc<AtomicBool>,
    sent: Arc<AtomicU32>,
    thread: Option<JoinHandle<()>>,
}

impl Vehicle {
    fn fly(station: SharedStation) -> Self {
        let (stop, silent) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicBool::new(false)));
        let sent = Arc::new(AtomicU32::new(0));
        let (ends, quiet, count) = (Arc::clone(&stop), Arc::clone(&silent), Arc::clone(&sent));
        let thread = Some(thread::spawn(move || {
            let begun_s = now_s();
            let start = begun_s - 65.0;
            for number in 0.. {
                if ends.load(Ordering::Relaxed) {
                    break;
                }
                let due_s = start + f64::from(number) / 33.0;
                thread::sleep(Duration::from_secs_f64((due_s - now_s()).max(0.0)));
                if !quiet.load(Ordering::Relaxed) {
                    let arrival_s = if due_s < begun_s { due_s } else { now_s() };
                    lock(&station).receive(&cycle(number), arrival_s);
                    count.fetch_add(2, Ordering::Relaxed);
                }
                lock(&station).tick(now_s());
            }
        }));
        Self { stop, silent, sent, thread }
    }
}

impl Drop for Vehicle {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

const VALUE: &str = "document.querySelectorAll('#plots .value')";

/// No card and no name of a stick is cut off.
const WHOLE_CARDS: &str = "[...document.querySelectorAll('.card, .stick span')].every((one) => one.scrollWidth <= one.clientWidth)";

#[test]
fn an_engineer_watches_zooms_records_and_retrieves() {
    let Some(chromium) = chromium() else { return };
    let served = serve(None);
    let vehicle = Vehicle::fly(Arc::clone(&served.station));
    let mut page = Browser::open(&chromium, &format!("http://{}/", served.address), 1400, 950);
    page.wait("document.querySelectorAll('#plots .plot canvas').length === 6");
    let painted = "performance.getEntriesByName('first-contentful-paint')[0]?.startTime ?? null";
    println!("first paint after {} ms", page.eval(painted));

    // Six channels, each found with one or two words and the keyboard only.
    let searches = ["roll rate", "velu", "pilot pedal", "satellites", "gauss z", "temperature"];
    for (place, words) in searches.iter().enumerate() {
        page.eval(&format!("document.querySelectorAll('#plots .name')[{place}].click()"));
        page.wait("document.getElementById('chooser').open");
        page.write(words);
        page.key("Enter");
        page.wait("!document.getElementById('chooser').open");
    }
    let names = page
        .eval("[...document.querySelectorAll('#plots .name')].map((n) => n.textContent).join()");
    assert_eq!(names, "Roll rate p,VelU, up,Pilot pedal,Satellites,Magnetic field z,Temperature");
    page.wait(&format!("{VALUE}[3].textContent.startsWith('9')"));

    // The plots move.
    let before = page.eval(&format!("{VALUE}[0].textContent"));
    page.wait(&format!("{VALUE}[0].textContent !== {before}"));
    let oldest = "station.clock.t - station.seriesOf('p_degps')[0][0]";
    let shown_s = page.eval(oldest).as_f64().unwrap();
    assert!(shown_s >= 60.0, "{shown_s} s of the window of 60 s");
    let (mut frames, mut delays) = (Vec::new(), Vec::new());
    for _ in 0..20 {
        thread::sleep(Duration::from_millis(250));
        frames.push(page.eval("Number(document.documentElement.dataset.frames)").as_u64().unwrap());
        delays
            .push(page.eval("Number(document.documentElement.dataset.delayMs)").as_i64().unwrap());
    }
    println!("frames a second {frames:?}, delays {delays:?} ms");

    // Paused, the view stays and no data are lost; after that it moves again.
    page.key(" ");
    page.wait("!station.axis.follows");
    let to = page.eval("station.axis.to").as_f64().unwrap();
    thread::sleep(Duration::from_millis(1500));
    assert_eq!(page.eval("station.axis.to").as_f64().unwrap(), to);
    page.key(" ");
    page.wait(&format!("station.axis.follows && station.clock.t > {to} + 1"));
    page.keep("plots");

    // Zoom box, zoom keys, pan, and reset.
    page.drag("#plots .u-over", (0.7, 0.2), (0.9, 0.8));
    page.wait("!station.axis.follows && station.axis.to - station.axis.from < 30");
    // The box changes the values of the dragged plot alone.
    page.wait("station.fixed().join() === 'true,false,false,false,false,false'");
    let span = page.eval("station.axis.to - station.axis.from").as_f64().unwrap();
    page.key("+");
    page.wait(&format!("station.axis.to - station.axis.from < {span} * 0.6"));
    let from = page.eval("station.axis.from").as_f64().unwrap();
    page.key("ArrowLeft");
    page.wait(&format!("station.axis.from < {from}"));
    page.key("0");
    page.wait("station.axis.follows");

    // Record with a name and a marker.
    page.key("r");
    page.wait("document.getElementById('asker').open");
    page.eval("document.getElementById('reply').value = ''");
    page.write("hover 1");
    page.key("Enter");
    page.wait("!document.getElementById('recording').hidden");
    page.key("m");
    page.wait("document.getElementById('asker').open");
    page.write("trimmed");
    page.key("Enter");
    page.wait("document.getElementById('markers').textContent.includes('trimmed')");
    thread::sleep(Duration::from_secs(3));
    page.key("r");
    page.wait("document.getElementById('recording').hidden");

    // An interrupted link is reported, and the plot has a gap.
    vehicle.silent.store(true, Ordering::Relaxed);
    for place in ["alarms", "link", "lamps", "flies", "ready"] {
        let text = format!("document.getElementById('{place}').textContent");
        page.wait(&format!("{text}.includes('no telemetry for')"));
    }
    page.wait("document.title.includes('no telemetry for')");
    page.wait("document.querySelectorAll('#lamps .lamp:not(.unknown)').length === 0");
    page.wait("document.querySelectorAll('#plots .plot:not(.stale)').length === 0");
    page.wait("document.documentElement.dataset.sounds > 0");
    page.wait("[...station.now.values()].every((value) => value === null)");
    page.wait("document.getElementById('mode-why').textContent === ''");
    page.wait("document.getElementById('angles').textContent.startsWith('roll –°')");
    page.keep("cut");
    vehicle.silent.store(false, Ordering::Relaxed);
    page.wait("!document.getElementById('alarms').textContent.includes('no telemetry')");
    page.wait("document.querySelector('#lamps .good') && !document.title.includes('no telemetry')");

    // Retrieve, seek, play, export.
    page.key("4");
    page.wait("document.querySelector('#list button')");
    page.keep("records");
    page.click("#list button");
    page.wait("!document.getElementById('player').hidden");
    page.key("1");
    page.eval("(() => { const s = document.getElementById('seek'); s.value = 500; s.oninput(); s.onchange(); })()");
    page.wait("Math.abs(Number(document.getElementById('seek').value) - 500) < 30");
    page.wait("document.getElementById('markers').textContent.includes('trimmed')");
    page.keep("record");
    page.key(" ");
    page.wait("document.getElementById('play').textContent.includes('Pause') || document.getElementById('seek').value > 600");
    page.eval(
        "window.got = null; const open = HTMLAnchorElement.prototype.click; \
               HTMLAnchorElement.prototype.click = function () { window.got = this.href; }; true",
    );
    page.key("e");
    page.wait("window.got");
    let lines = page
        .eval("fetch(window.got).then((a) => a.text()).then((text) => text.split('\\n').length)");
    assert!(lines.as_u64().unwrap() > 30, "{lines}");
    page.key("l");
    page.wait("document.getElementById('player').hidden");

    // The map is drawn, and its track has another colour by mode.
    let map = "document.getElementById('track').toDataURL()";
    let by_time = page.eval(map);
    page.click("#colours");
    page.wait("document.getElementById('colours').textContent === 'Track: by mode'");
    assert_ne!(page.eval(map), by_time);

    // The other views, themes, and a phone.
    for (key, name) in [("2", "hover"), ("5", "log"), ("3", "points")] {
        page.key(key);
        thread::sleep(Duration::from_millis(700));
        page.wait(WHOLE_CARDS);
        if name == "points" {
            page.wait(
                "document.querySelector('#progress tbody td:last-child')?.textContent === 'good'",
            );
        }
        page.keep(name);
    }
    page.key("1");
    for theme in ["light", "dark", "sun"] {
        page.key("t");
        page.wait(&format!("document.documentElement.dataset.theme === '{theme}'"));
    }
    // Clicks on colours and sound: the plots stay visible.
    for _ in 0..4 {
        page.click("#theme");
    }
    page.click("#sound");
    page.click("#sound");
    assert_eq!(page.eval("document.documentElement.dataset.theme"), "sun");
    page.wait("!document.getElementById('tab-plots').hidden");
    thread::sleep(Duration::from_millis(400));
    page.keep("sun");
    // Nothing is cut off in any view, in the largest letters, on a laptop and on a tablet.
    for (width, height, name) in [(1400, 950, "laptop"), (820, 1180, "tablet")] {
        page.size(width, height, width < 1000);
        for (key, view) in
            [("2", "hover"), ("3", "points"), ("4", "records"), ("5", "log"), ("1", "plots")]
        {
            page.key(key);
            page.wait(&format!(
                "innerWidth === {width} && document.documentElement.scrollWidth <= innerWidth"
            ));
            page.wait(WHOLE_CARDS);
            thread::sleep(Duration::from_millis(400));
            page.keep(&format!("{name}-{view}"));
        }
    }
    page.size(390, 844, true);
    // Nothing is cut off.
    page.wait("innerWidth === 390 && document.documentElement.scrollWidth <= innerWidth");
    // The first plot is in the first screen. The bar stays where the page is scrolled.
    page.wait(
        "document.querySelector('#plots .chart').getBoundingClientRect().bottom < innerHeight",
    );
    page.eval("scrollTo(0, 3000)");
    for node in ["link", "flies", "can", "record", "mark"] {
        let place = format!("document.getElementById('{node}').getBoundingClientRect()");
        page.wait(&format!("{place}.top >= 0 && {place}.bottom < 140 && {place}.height > 0"));
    }
    page.eval("scrollTo(0, 0)");
    page.keep("phone");

    // The layout is kept over a reload, and no frame is lost.
    page.call("Page.reload", serde_json::json!({}));
    page.wait("document.querySelectorAll('#plots .name')[3]?.textContent === 'Satellites'");
    assert_eq!(page.eval("document.documentElement.dataset.theme"), "sun");
    let sent = vehicle.sent.load(Ordering::Relaxed);
    let link = lock(&served.station).link(now_s());
    assert!(link.frames + 4 >= u64::from(sent), "{} of {sent}", link.frames);
    assert!(page.said.is_empty(), "{:?}", page.said);

    // Without the station nothing on the page looks alive.
    drop(served);
    for place in ["link", "lamps", "flies", "ready"] {
        let text = format!("document.getElementById('{place}').textContent");
        page.wait(&format!("{text}.includes('no connection to the station')"));
    }
    page.wait("document.querySelectorAll('#lamps .lamp:not(.unknown)').length === 0");
    page.wait("station.now.size === 0 && document.title.includes('no connection')");
}

/// Not a test: a page to look at, for ten minutes.
#[test]
#[ignore = "serves a page to look at"]
fn serves_a_page_to_look_at() {
    let served = serve(None);
    let _vehicle = Vehicle::fly(Arc::clone(&served.station));
    println!("http://{}/", served.address);
    thread::sleep(Duration::from_secs(600));
}

#[test]
fn a_page_without_the_token_says_what_is_missing() {
    let Some(chromium) = chromium() else { return };
    let served = serve(Some("0123456789abcdef"));
    let address = format!("http://{}/", served.address);
    let mut page = Browser::open(&chromium, &address, 1400, 950);
    page.wait("document.getElementById('alarms').textContent.includes('found no token')");
    page.call(
        "Page.navigate",
        serde_json::json!({"url": format!("{address}#token=0123456789abcdef")}),
    );
    page.wait("document.getElementById('alarms').textContent.includes('no telemetry yet')");
}
