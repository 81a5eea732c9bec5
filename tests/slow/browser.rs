//! A headless Chromium, spoken to over pipes in its DevTools protocol. One that does not answer fails its test.

use base64::Engine;
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};
use trackfail_testing::conditions::{BROWSERS, runs};
use trackfail_testing::within;

/// Text of the line above the viewer.
pub const READOUT: &str = "document.getElementById('readout').textContent";

/// The width of the picture that the viewer shows.
pub const PICTURE_WIDTH: &str = "(async () => { const i = new Image(); i.src = document.querySelector('#stage image').href.baseVal; await i.decode(); return i.width; })()";

/// How long the browser may think about anything.
const PATIENCE: Duration = Duration::from_secs(120);

/// Chromium with one page.
pub struct Browser {
    process: Child,
    to: ChildStdin,
    // Read by a thread of its own, which may wait for ever.
    from: Receiver<Vec<u8>>,
    last: u64,
    session: String,
    events: Vec<Value>,
    // Its profile; gone with it.
    _folder: tempfile::TempDir,
}

impl Browser {
    /// Starts Chromium; its test is marked `#[needs(chromium)]`.
    pub fn start() -> Self {
        let name = BROWSERS.into_iter().find(|name| runs(name, &["--version"]));
        let name = name.expect("the Chromium that was there when this test was compiled has gone");
        let folder = tempfile::tempdir().unwrap();
        // The browser reads commands from descriptor 3 and answers on descriptor 4.
        let script = r#"exec "$0" --headless=new --no-sandbox --disable-gpu --disable-dev-shm-usage --no-first-run \
            --disable-background-networking --disable-component-update --disable-sync --hide-scrollbars \
            --user-data-dir="$1" --remote-debugging-pipe about:blank 3<&0 4>&1 </dev/null >/dev/null"#;
        let mut shell = Command::new("sh");
        shell.args(["-c", script, name]).arg(folder.path().join("profile"));
        shell.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut process = shell.spawn().unwrap();
        let (to, from) = (process.stdin.take().unwrap(), reader(process.stdout.take().unwrap()));
        let (session, events) = (String::new(), Vec::new());
        let mut browser = Self { process, to, from, last: 0, session, events, _folder: folder };
        let target = browser.call("Target.createTarget", json!({"url": "about:blank"}))["targetId"].clone();
        let attached = browser.call("Target.attachToTarget", json!({"targetId": target, "flatten": true}));
        browser.session = attached["sessionId"].as_str().unwrap().to_string();
        for domain in ["Page", "Runtime", "Log", "Network"] {
            browser.call(&format!("{domain}.enable"), json!({}));
        }
        browser
    }

    fn read(&mut self) -> Value {
        match self.from.recv_timeout(PATIENCE) {
            Ok(bytes) => serde_json::from_slice(&bytes).unwrap(),
            Err(RecvTimeoutError::Timeout) => panic!("chromium does not answer within {PATIENCE:?}"),
            Err(RecvTimeoutError::Disconnected) => panic!("chromium has gone"),
        }
    }

    /// Calls a method of the protocol and gives its result.
    pub fn call(&mut self, method: &str, parameters: Value) -> Value {
        self.ask(method, parameters).unwrap_or_else(|error| panic!("{method}: {error}"))
    }

    /// Calls a method of the protocol and gives its result or its error.
    fn ask(&mut self, method: &str, parameters: Value) -> Result<Value, Value> {
        self.last += 1;
        let mut message = json!({"id": self.last, "method": method, "params": parameters});
        if !self.session.is_empty() {
            message["sessionId"] = self.session.clone().into();
        }
        let mut bytes = message.to_string().into_bytes();
        bytes.push(0);
        self.to.write_all(&bytes).expect("chromium has gone");
        loop {
            let answer = self.read();
            if answer["id"] == self.last {
                let error = answer["error"].clone();
                return if error.is_null() { Ok(answer["result"].clone()) } else { Err(error) };
            }
            self.events.push(answer);
        }
    }

    /// Shows pages as on a screen of this size, dark or light.
    pub fn screen(&mut self, width: u32, height: u32, dark: bool) {
        let size = json!({"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600});
        self.call("Emulation.setDeviceMetricsOverride", size);
        let scheme = json!({"name": "prefers-color-scheme", "value": if dark { "dark" } else { "light" }});
        let still = json!({"name": "prefers-reduced-motion", "value": "reduce"});
        self.call("Emulation.setEmulatedMedia", json!({"features": [scheme, still]}));
    }

    /// Opens a file and waits until it is loaded.
    pub fn open(&mut self, file: &Path) {
        self.events.clear();
        self.call("Page.navigate", json!({"url": format!("file://{}", file.display())}));
        while !self.events.iter().any(|e| e["method"] == "Page.loadEventFired") {
            let event = self.read();
            self.events.push(event);
        }
    }

    /// The value of an expression in the page; while the page gives way to another one, in that.
    pub fn value(&mut self, expression: &str) -> Value {
        let asked = json!({"expression": expression, "returnByValue": true, "awaitPromise": true});
        let end = Instant::now() + PATIENCE;
        let result = loop {
            match self.ask("Runtime.evaluate", asked.clone()) {
                Ok(result) => break result,
                Err(error) => {
                    let message = error["message"].as_str().unwrap_or_default();
                    let gone = ["navigated or closed", "context"].iter().any(|words| message.contains(words));
                    assert!(gone && Instant::now() < end, "{expression}: {error}");
                    thread::sleep(Duration::from_millis(25));
                }
            }
        };
        assert!(result["exceptionDetails"].is_null(), "{expression}: {}", result["exceptionDetails"]);
        result["result"]["value"].clone()
    }

    /// The value of an expression that is a text.
    pub fn text(&mut self, expression: &str) -> String {
        let value = self.value(expression);
        value.as_str().unwrap_or_else(|| panic!("{expression}: {value}")).to_string()
    }

    /// Asserts that an expression becomes true, as long as that takes on a busy machine.
    pub fn becomes(&mut self, expression: &str) {
        let is_true = within(PATIENCE, || self.value(expression) == true);
        let told = "document.getElementById('readout')?.textContent";
        assert!(is_true, "not true: {expression}; {}", self.value(told));
    }

    /// Puts the focus on what an expression gives.
    pub fn focus(&mut self, expression: &str) {
        self.value(&format!("{expression}.focus()"));
    }

    /// The number of the frame that the viewer shows.
    pub fn frame(&mut self) -> i64 {
        let text = self.text(READOUT);
        text.split(' ').nth(1).and_then(|n| n.parse().ok()).unwrap_or_else(|| panic!("{text}"))
    }

    pub fn has_no_sideways_scroll(&mut self) {
        let widths = self.value("[document.documentElement.scrollWidth, innerWidth]");
        assert!(widths[0].as_i64() <= widths[1].as_i64(), "{widths}");
    }

    /// Opens a file on a desk and on a phone, light and dark; it must fit, and neither complain nor ask for addresses that do
    /// not begin with `own`.
    pub fn on_all_screens(&mut self, name: &str, file: &Path, own: &str, works: impl Fn(&mut Self, bool)) {
        for (width, dark) in [(1400, false), (1400, true), (390, false), (390, true)] {
            self.screen(width, 900, dark);
            self.open(file);
            self.has_no_sideways_scroll();
            works(self, dark);
            assert_eq!(self.complaints(own), Vec::<String>::new());
            self.picture(&format!("{name}-{width}-{}", if dark { "dark" } else { "light" }));
        }
    }

    /// Presses a key where the focus is.
    pub fn press(&mut self, key: &str) {
        let code = match key {
            "Enter" => 13,
            "End" => 35,
            "Home" => 36,
            "ArrowLeft" => 37,
            "ArrowRight" => 39,
            _ => u32::from(key.to_ascii_uppercase().as_bytes()[0]),
        };
        let mut down = json!({"type": "keyDown", "key": key, "windowsVirtualKeyCode": code});
        match key {
            "Enter" => down["text"] = "\r".into(),
            letter if letter.len() == 1 => down["text"] = letter.into(),
            _ => down["type"] = "rawKeyDown".into(),
        }
        self.call("Input.dispatchKeyEvent", down);
        let up = json!({"type": "keyUp", "key": key, "windowsVirtualKeyCode": code});
        self.call("Input.dispatchKeyEvent", up);
    }

    /// Clicks into the middle of what `expression` gives.
    pub fn click(&mut self, expression: &str) {
        let place = format!(
            "(() => {{ const e = {expression}; e.scrollIntoView({{block: 'center', behavior: 'instant'}}); \
             const r = e.getBoundingClientRect(); return [r.x + r.width / 2, r.y + r.height / 2]; }})()"
        );
        let at = self.value(&place);
        for kind in ["mousePressed", "mouseReleased"] {
            let event = json!({"type": kind, "x": at[0], "y": at[1], "button": "left", "clickCount": 1});
            self.call("Input.dispatchMouseEvent", event);
        }
    }

    /// Messages on the console, errors, and addresses that were asked for and do not begin with `allowed`.
    pub fn complaints(&mut self, allowed: &str) -> Vec<String> {
        // Whatever happened before this call is told before its answer.
        self.value("1");
        let complaint = |e: &Value| match e["method"].as_str()? {
            "Runtime.exceptionThrown" | "Runtime.consoleAPICalled" | "Log.entryAdded" => {
                Some(e["params"].to_string())
            }
            "Network.requestWillBeSent" => {
                let url = e["params"]["request"]["url"].as_str()?;
                (!url.starts_with(allowed) && !url.starts_with("data:")).then(|| url.to_string())
            }
            _ => None,
        };
        self.events.iter().filter_map(complaint).collect()
    }

    /// Keeps a picture of the page where `TRACKFAIL_SCREENSHOTS` says, if it does.
    pub fn picture(&mut self, name: &str) {
        let Some(folder) = std::env::var_os("TRACKFAIL_SCREENSHOTS") else { return };
        let asked = json!({"format": "png", "captureBeyondViewport": true});
        let shot = self.call("Page.captureScreenshot", asked);
        std::fs::create_dir_all(&folder).unwrap();
        let png = base64::engine::general_purpose::STANDARD.decode(shot["data"].as_str().unwrap()).unwrap();
        std::fs::write(Path::new(&folder).join(format!("{name}.png")), png).unwrap();
    }
}

/// Messages from a pipe, each of which ends with a zero.
fn reader(pipe: ChildStdout) -> Receiver<Vec<u8>> {
    let (sender, messages) = channel();
    thread::spawn(move || {
        let mut all = BufReader::new(pipe).split(0).map_while(Result::ok);
        let _ = all.try_for_each(|message| sender.send(message));
    });
    messages
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
