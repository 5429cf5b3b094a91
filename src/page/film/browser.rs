//! The pictures of a film from the page of a run, by a browser without a display.
//!
//! ```text
//!     chromium ◀─ {"id":…,"method":…,"params":…}␀ ─ descriptor 3        Chrome DevTools Protocol over pipes
//!              ─ {"id":…,"result":…}␀ ─▶ descriptor 4
//!     Page.navigate page.html#film&view=x,y,z ; for each picture: Runtime.evaluate film(t) ; Page.captureScreenshot
//! ```
//!
//! `film(t)` is the page's own function (`page/assets/main.js`). A shell gives the browser the two descriptors, because a Rust program can hand on only
//! standard input and output. Source: <https://chromedevtools.github.io/devtools-protocol/>.

use crate::film::camera::View;
use crate::film::canvas::Image;
use crate::film::error::FilmError;
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Cursor, Write};
use std::path::PathBuf;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

/// Programs that are looked for, in this order.
const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "chrome"];

/// The longest wait for an answer. Pages of many megabytes open in some ten seconds where graphics are drawn in software.
const PATIENCE: Duration = Duration::from_secs(120);

/// How often a page that opens is asked whether it is ready.
const INTERVAL: Duration = Duration::from_millis(20);

/// How many browsers this process has started.
static STARTED: AtomicUsize = AtomicUsize::new(0);

/// A browser that shows a page.
pub(super) struct Browser {
    child: Child,
    input: ChildStdin,
    answers: Receiver<Value>,
    session: Option<String>,
    asked: u64,
    folder: PathBuf,
}

impl Browser {
    /// Opens a page in a picture of this size (pixels), seen from a side.
    ///
    /// # Errors
    /// [`FilmError::Browser`].
    pub(super) fn open(page: &str, view: View, size: [usize; 2]) -> Result<Self, FilmError> {
        // A browser of the administrator starts only without its sandbox; the page is the program's own.
        let mut browser = Browser::start(&[], size).or_else(|_| Browser::start(&["--no-sandbox"], size))?;
        let file = browser.folder.join("run.html");
        std::fs::create_dir_all(&browser.folder)
            .and_then(|()| std::fs::write(&file, page))
            .map_err(|reason| FilmError::write(&file, reason))?;
        browser.show(&format!("file://{}#film&view={}", file.display(), view.address()))?;
        Ok(browser)
    }

    fn start(more: &[&str], [width, height]: [usize; 2]) -> Result<Self, FilmError> {
        let number = STARTED.fetch_add(1, Ordering::Relaxed);
        let folder = std::env::temp_dir().join(format!("catena-film-{}-{number}", std::process::id()));
        let has = |name: &&&str| Command::new(name).arg("--version").output().is_ok_and(|said| said.status.success());
        let name = NAMES
            .iter()
            .find(has)
            .ok_or_else(|| failed(format!("there is none of {} on the PATH; leave --browser out", NAMES.join(", "))))?;
        let profile = format!("--user-data-dir={}", folder.join("profile").display());
        let mut child = Command::new("sh")
            .args(["-c", r#"exec "$0" "$@" 3<&0 4>&1 </dev/null >/dev/null 2>&1"#, name])
            .args(["--headless", "--remote-debugging-pipe", "--hide-scrollbars", "--disable-dev-shm-usage"])
            .args(["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-first-run"])
            .args(more)
            .arg(profile)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .map_err(|error| failed(format!("a shell, which it needs for its pipes, did not start: {error}")))?;
        let pipes = child.stdin.take().zip(child.stdout.take());
        let (input, output) = pipes.ok_or_else(|| failed("its pipes are missing".to_string()))?;
        let (to, answers) = channel();
        std::thread::spawn(move || {
            let mut output = BufReader::new(output);
            let mut text = Vec::new();
            while output.read_until(0, &mut text).is_ok_and(|count| count > 0) {
                text.pop();
                let sent = serde_json::from_slice(&text).map(|answer: Value| to.send(answer));
                if !matches!(sent, Ok(Ok(()))) {
                    return;
                }
                text.clear();
            }
        });
        let mut browser = Browser { child, input, answers, session: None, asked: 0, folder };
        let target = browser.ask("Target.createTarget", &json!({"url": "about:blank"}))?;
        let attached =
            browser.ask("Target.attachToTarget", &json!({"targetId": target["targetId"], "flatten": true}))?;
        browser.session = attached["sessionId"].as_str().map(str::to_string);
        let metrics = json!({"width": width, "height": height, "deviceScaleFactor": 1, "mobile": false});
        browser.ask("Emulation.setDeviceMetricsOverride", &metrics)?;
        Ok(browser)
    }

    /// Goes to an address and waits until the page is ready.
    fn show(&mut self, address: &str) -> Result<(), FilmError> {
        self.ask("Page.navigate", &json!({"url": address}))?;
        let begun = Instant::now();
        loop {
            let state = self.evaluate("document.documentElement && document.documentElement.dataset.state")?;
            match state.as_str() {
                Some("ready") => return Ok(()),
                Some("failed") => {
                    let reason = self.evaluate("byId('message').textContent")?;
                    return Err(failed(reason.as_str().unwrap_or("the page failed").to_string()));
                }
                _ if begun.elapsed() > PATIENCE => return Err(failed("the page did not open".to_string())),
                _ => std::thread::sleep(INTERVAL),
            }
        }
    }

    /// Draws the instant `time` (s).
    ///
    /// # Errors
    /// [`FilmError::Browser`].
    pub(super) fn draw(&mut self, time: f64, image: &mut Image) -> Result<(), FilmError> {
        self.evaluate(&format!("film({time})"))?;
        let answer = self.ask("Page.captureScreenshot", &json!({"format": "png", "optimizeForSpeed": true}))?;
        let bytes = answer["data"].as_str().and_then(bytes_of_base64);
        let bytes = bytes.ok_or_else(|| failed("a picture is no base64".to_string()))?;
        let broken = |error: png::DecodingError| failed(format!("a picture is no PNG: {error}"));
        let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().map_err(broken)?;
        let size = reader.output_buffer_size().ok_or_else(|| failed("a picture is too large".to_string()))?;
        let mut pixels = vec![0; size];
        let info = reader.next_frame(&mut pixels).map_err(broken)?;
        (image.width, image.height) = (info.width as usize, info.height as usize);
        let samples = info.color_type.samples();
        let is_colour = samples >= 3 && info.bit_depth == png::BitDepth::Eight;
        if !is_colour {
            return Err(failed("a picture has no colours of one byte".to_string()));
        }
        image.pixels = pixels.chunks_exact(samples).map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
        Ok(())
    }

    fn evaluate(&mut self, expression: &str) -> Result<Value, FilmError> {
        let answer = self.ask("Runtime.evaluate", &json!({"expression": expression, "awaitPromise": true}))?;
        match answer.get("exceptionDetails") {
            Some(details) => Err(failed(format!("its page says {}", details["exception"]["description"]))),
            None => Ok(answer["result"]["value"].clone()),
        }
    }

    /// Sends a command and waits for its answer.
    fn ask(&mut self, method: &str, params: &Value) -> Result<Value, FilmError> {
        self.asked += 1;
        let mut message = json!({"id": self.asked, "method": method, "params": params});
        if let Some(session) = &self.session {
            message["sessionId"] = json!(session);
        }
        let sent = write!(self.input, "{message}\0").and_then(|()| self.input.flush());
        sent.map_err(|error| failed(format!("it has ended: {error}")))?;
        loop {
            let answer = self.answers.recv_timeout(PATIENCE);
            let mut answer = answer.map_err(|_| failed(format!("it does not answer to {method}")))?;
            if answer["id"] == json!(self.asked) {
                return match answer.get("error") {
                    Some(error) => Err(failed(format!("{method}: {}", error["message"]))),
                    None => Ok(answer["result"].take()),
                };
            }
        }
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        self.session = None;
        // A browser that has ended already cannot be asked to.
        if self.ask("Browser.close", &json!({})).is_err() {
            let _ = self.child.kill();
        }
        let _ = self.child.wait();
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

fn failed(reason: String) -> FilmError {
    FilmError::Browser { reason }
}

/// The bytes of a text in base64 (RFC 4648); `None` if it is none.
fn bytes_of_base64(text: &str) -> Option<Vec<u8>> {
    let digit = |letter: u8| match letter {
        b'A'..=b'Z' => Some(letter - b'A'),
        b'a'..=b'z' => Some(letter - b'a' + 26),
        b'0'..=b'9' => Some(letter - b'0' + 52),
        b'+' => Some(62),
        b'/' => Some(63),
        _ => None,
    };
    let letters = text.trim_end_matches('=').as_bytes();
    let mut bytes = Vec::with_capacity(letters.len() * 3 / 4);
    for four in letters.chunks(4) {
        let word = four.iter().try_fold(0u32, |word, letter| Some(word << 6 | u32::from(digit(*letter)?)))?;
        let word = word << (6 * (4 - four.len()));
        bytes.extend(word.to_be_bytes().iter().skip(1).take(four.len() * 3 / 4));
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::bytes_of_base64;

    #[test]
    fn base64_is_read_as_the_standard_says() {
        // The test vectors of RFC 4648, section 10.
        let cases =
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foob", "Zm9vYg=="), ("foobar", "Zm9vYmFy")];
        for (plain, text) in cases {
            assert_eq!(bytes_of_base64(text).as_deref(), Some(plain.as_bytes()));
        }
        assert_eq!(bytes_of_base64("Zm9v Yg"), None);
    }
}
