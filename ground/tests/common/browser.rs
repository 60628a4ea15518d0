//! A headless Chromium, controlled with its DevTools protocol.
//!
//! Source: Chrome DevTools Protocol, domains Page, Runtime, Input and Emulation.
#![allow(dead_code, reason = "each test uses a part")]

use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tungstenite::{Message, WebSocket};

/// Names of the Chromium executable.
const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];

/// A page in its own browser; both end on drop.
pub struct Browser {
    child: Child,
    socket: WebSocket<TcpStream>,
    next: u64,
    /// Console messages and errors of the page.
    pub said: Vec<String>,
    _profile: tempfile::TempDir,
}

/// The Chromium executable; `None` with a skip message if it is missing.
pub fn chromium() -> Option<PathBuf> {
    let given = std::env::var_os("CHROMIUM").map(PathBuf::from);
    let starts = |program: &PathBuf| Command::new(program).arg("--version").output().is_ok();
    let found = given.into_iter().chain(NAMES.map(PathBuf::from)).find(starts);
    if found.is_none() {
        hovernav_testing::skip(format_args!("none of {NAMES:?} nor $CHROMIUM starts"));
    }
    found
}

impl Browser {
    pub fn open(chromium: &Path, url: &str, width: u32, height: u32) -> Self {
        let profile = tempfile::tempdir().unwrap();
        let child = Command::new(chromium)
            .args(["--headless=new", "--no-sandbox", "--disable-gpu", "--remote-debugging-port=0"])
            .args(["--force-prefers-reduced-motion", "--hide-scrollbars", "--no-first-run"])
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .arg("about:blank")
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let file = profile.path().join("DevToolsActivePort");
        let port: u16 = patient("Chromium's port", || {
            std::fs::read_to_string(&file).ok()?.lines().next()?.parse().ok()
        });
        let target = patient("Chromium's page", || page(port));
        let stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        let (socket, _) = tungstenite::client(target, stream).unwrap();
        let mut browser = Self { child, socket, next: 0, said: Vec::new(), _profile: profile };
        for domain in ["Page", "Runtime", "Log"] {
            browser.call(&format!("{domain}.enable"), json!({}));
        }
        browser.size(width, height, false);
        browser.call("Page.navigate", json!({"url": url}));
        browser.wait("location.href !== 'about:blank' && document.readyState === 'complete'");
        browser
    }

    /// Sets the size of the screen, CSS pixels.
    pub fn size(&mut self, width: u32, height: u32, mobile: bool) {
        let screen =
            json!({"width": width, "height": height, "deviceScaleFactor": 1, "mobile": mobile});
        self.call("Emulation.setDeviceMetricsOverride", screen);
    }

    pub fn call(&mut self, method: &str, params: Value) -> Value {
        self.next += 1;
        let request = json!({"id": self.next, "method": method, "params": params});
        self.socket.send(Message::text(request.to_string())).unwrap();
        loop {
            let Message::Text(text) = self.socket.read().unwrap() else { continue };
            let message: Value = serde_json::from_str(&text).unwrap();
            if message["id"] == self.next {
                assert!(message.get("error").is_none(), "{method}: {message}");
                return message["result"].clone();
            }
            match message["method"].as_str() {
                Some("Runtime.exceptionThrown") => {
                    self.said.push(message["params"]["exceptionDetails"].to_string());
                }
                Some("Log.entryAdded") => {
                    self.said.push(message["params"]["entry"]["text"].to_string());
                }
                _ => {}
            }
        }
    }

    /// The value of `script`.
    pub fn eval(&mut self, script: &str) -> Value {
        let params = json!({"expression": script, "returnByValue": true, "awaitPromise": true});
        let result = self.call("Runtime.evaluate", params);
        assert!(result.get("exceptionDetails").is_none(), "{script}: {result}");
        result["result"]["value"].clone()
    }

    /// Waits until `script` is true.
    pub fn wait(&mut self, script: &str) {
        let until = Instant::now() + Duration::from_secs(30);
        while self.eval(&format!("Boolean({script})")) != true {
            assert!(Instant::now() < until, "timeout after 30 s: {script}; {:?}", self.said);
            thread::sleep(Duration::from_millis(50));
        }
    }

    pub fn click(&mut self, selector: &str) {
        self.eval(&format!("document.querySelector({selector:?}).click()"));
    }

    /// Types a key, such as `r` or `Enter`.
    pub fn key(&mut self, key: &str) {
        let text = if key.chars().count() == 1 { key } else { "" };
        for kind in ["keyDown", "keyUp"] {
            let mut event = json!({"type": kind, "key": key});
            if kind == "keyDown" && !text.is_empty() {
                event["text"] = json!(text);
            }
            if key == "Enter" {
                event["windowsVirtualKeyCode"] = json!(13);
                event["text"] = json!("\r");
            }
            self.call("Input.dispatchKeyEvent", event);
        }
    }

    /// Inserts text at the cursor.
    pub fn write(&mut self, text: &str) {
        self.call("Input.insertText", json!({"text": text}));
    }

    /// Drags the mouse over the first element of `selector`, between two points given as fractions of its width and
    /// height.
    pub fn drag(&mut self, selector: &str, from: (f64, f64), to: (f64, f64)) {
        let place = self.eval(&format!(
            "(() => {{ const r = document.querySelector({selector:?}).getBoundingClientRect(); \
             return [r.left, r.top, r.width, r.height]; }})()"
        ));
        let place: Vec<f64> =
            place.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
        let mut event = |kind: &str, part: (f64, f64), buttons: u32| {
            let (x, y) = (place[0] + part.0 * place[2], place[1] + part.1 * place[3]);
            let event = json!({
                "type": kind, "x": x, "y": y, "button": if buttons > 0 || kind == "mouseReleased" { "left" } else { "none" },
                "buttons": buttons, "clickCount": 1,
            });
            self.call("Input.dispatchMouseEvent", event);
        };
        event("mouseMoved", from, 0);
        event("mousePressed", from, 1);
        for step in 1..=8 {
            let part = f64::from(step) / 8.0;
            let between = (from.0 + part * (to.0 - from.0), from.1 + part * (to.1 - from.1));
            event("mouseMoved", between, 1);
        }
        event("mouseReleased", to, 0);
    }

    /// A screenshot of the page, as PNG.
    pub fn picture(&mut self) -> Vec<u8> {
        let shot = self.call("Page.captureScreenshot", json!({"format": "png"}));
        base64(shot["data"].as_str().unwrap())
    }

    /// Saves a screenshot in `$SCREENSHOTS`, if that is set.
    pub fn keep(&mut self, name: &str) {
        if let Some(place) = std::env::var_os("SCREENSHOTS") {
            let picture = self.picture();
            std::fs::write(Path::new(&place).join(format!("{name}.png")), picture).unwrap();
        }
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn patient<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let until = Instant::now() + Duration::from_secs(60);
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(Instant::now() < until, "{what} is missing after 60 s");
        thread::sleep(Duration::from_millis(50));
    }
}

/// The address of the page's DevTools.
fn page(port: u16) -> Option<String> {
    use std::io::{Read as _, Write as _};
    let mut stream = TcpStream::connect(("127.0.0.1", port)).ok()?;
    stream.set_read_timeout(Some(Duration::from_secs(5))).ok()?;
    let request =
        format!("GET /json/list HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nConnection: close\r\n\r\n");
    stream.write_all(request.as_bytes()).ok()?;
    let mut answer = Vec::new();
    // The browser may keep the connection open despite the request to close it.
    let _ = stream.read_to_end(&mut answer);
    let text = String::from_utf8_lossy(&answer).into_owned();
    let list: Value = serde_json::from_str(text.get(text.find('[')?..=text.rfind(']')?)?).ok()?;
    let page = list.as_array()?.iter().find(|target| target["type"] == "page")?;
    page["webSocketDebuggerUrl"].as_str().map(str::to_owned)
}

/// Decodes base64. Source: RFC 4648, section 4.
pub fn base64(text: &str) -> Vec<u8> {
    let value = |byte: u8| match byte {
        b'A'..=b'Z' => byte - b'A',
        b'a'..=b'z' => byte - b'a' + 26,
        b'0'..=b'9' => byte - b'0' + 52,
        b'+' => 62,
        _ => 63,
    };
    let digits: Vec<u8> = text.bytes().filter(|byte| *byte != b'=').map(value).collect();
    let mut bytes = Vec::with_capacity(digits.len());
    for group in digits.chunks(4) {
        let word = group
            .iter()
            .enumerate()
            .fold(0u32, |word, (k, digit)| word | u32::from(*digit) << (18 - 6 * k));
        bytes.extend(&word.to_be_bytes()[1..group.len()]);
    }
    bytes
}
