//! The servers of `view` and `setup` over real connections: what their pages ask for is answered, and nothing else is done.
#![allow(clippy::unwrap_used)]

use crate::common::page::data_of;
use crate::common::{exit_code, folder, messages, run, succeeds};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// A server that ends with its test.
struct Server {
    child: Child,
    /// Host and port.
    host: String,
    /// What stands before names: `/`, or `/TOKEN/`.
    root: String,
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Server {
    fn start(folder: &Path, arguments: &[&str]) -> Self {
        let mut child = Command::new(crate::PROGRAM)
            .args(arguments)
            .current_dir(folder)
            .env("XDG_CACHE_HOME", folder.join("caches"))
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap())
            .read_line(&mut line)
            .unwrap();
        let (_, address) = line
            .split_once("http://")
            .unwrap_or_else(|| panic!("no address in {line:?}"));
        let address = address.split([';', '\n']).next().unwrap();
        let (host, root) = address.split_once('/').unwrap();
        Self {
            child,
            host: host.to_owned(),
            root: format!("/{root}"),
        }
    }

    fn connect(&self) -> TcpStream {
        TcpStream::connect(&self.host).unwrap()
    }

    /// What comes back for these bytes.
    fn exchange(&self, request: &[u8]) -> String {
        let mut stream = self.connect();
        // Whoever is refused need not be listened to.
        let _ = stream.write_all(request);
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        String::from_utf8_lossy(&answer).into_owned()
    }

    fn get(&self, target: &str) -> String {
        self.exchange(format!("GET {target} HTTP/1.1\r\nHost: {}\r\n\r\n", self.host).as_bytes())
    }

    /// A request as the page sends it, but for the changes.
    fn post(&self, name: &str, body: &[u8], change: impl Fn(String) -> String) -> String {
        let (root, host) = (&self.root, &self.host);
        let head = format!(
            "POST {root}{name} HTTP/1.1\r\nHost: {host}\r\nOrigin: http://{host}\r\nContent-Type: application/json\r\n\
             Content-Length: {}\r\n\r\n",
            body.len()
        );
        self.exchange(&[change(head).as_bytes(), body].concat())
    }

    fn send(&self, name: &str, document: &Value) -> Value {
        let answer = self.post(name, document.to_string().as_bytes(), |head| head);
        assert_eq!(status(&answer), 200, "{answer:.300}");
        body(&answer)
    }

    /// Waits until a run has ended.
    fn end(&self) -> Value {
        for _ in 0..1200 {
            let told = body(&self.get(&format!("{}progress?from=0", self.root)));
            if !told["end"].is_null() {
                return told;
            }
            std::thread::sleep(Duration::from_millis(100));
        }
        panic!("the run does not end");
    }
}

fn status(answer: &str) -> u16 {
    let word = answer.split(' ').nth(1).unwrap_or_default();
    word.parse().unwrap_or_else(|_| panic!("no status in {answer:.200?}"))
}

fn body(answer: &str) -> Value {
    serde_json::from_str(answer.split_once("\r\n\r\n").unwrap().1).unwrap()
}

/// A folder with a lap joint and its scene, which leads to a file beside it.
fn lap(name: &str) -> PathBuf {
    let folder = folder(name);
    succeeds(
        &folder,
        &["new", "--benchmark", "chain-of-laps", "--joints", "1", "lap"],
    );
    std::fs::write(folder.join("secret"), "hidden").unwrap();
    folder
}

fn results(folder: &Path) {
    std::fs::create_dir_all(folder).unwrap();
    std::fs::write(folder.join("report.html"), "a report").unwrap();
    std::fs::write(folder.join(".hidden"), "hidden").unwrap();
    #[cfg(unix)]
    std::os::unix::fs::symlink("../../secret", folder.join("link")).unwrap();
}

/// Ways to files elsewhere from a folder of results.
const WAYS_OUT: [&str; 18] = [
    "",
    ".",
    "..",
    "../scene.json",
    "../../secret",
    "../report.html/../../secret",
    "%2e%2e/%2e%2e/secret",
    "..%2f..%2fsecret",
    "%2e%2e%5c%2e%2e%5csecret",
    "..\\..\\secret",
    "/etc/passwd",
    "//etc/passwd",
    "file:///etc/passwd",
    "report.html/../../../secret",
    "report.html\0",
    ".hidden",
    "link",
    "C:\\secret",
];

/// Asks for what must not be had, and counts.
fn refusals(server: &Server, folder: &str) -> usize {
    let found = server.get(&format!("{}{folder}report.html", server.root));
    assert!(status(&found) == 200 && found.ends_with("a report"), "{found:.300}");
    let mut count = 0;
    let mut refused = |answer: String, expected: u16, what: &str| {
        assert_eq!(status(&answer), expected, "{what}: {answer:.300}");
        assert!(!answer.contains("hidden") && !answer.contains("root:"), "{what}");
        count += 1;
    };
    for way in WAYS_OUT {
        let target = format!("{}{folder}{way}", server.root);
        // Blanks and controls end a target.
        let expected = if target == server.root { 200 } else { 404 };
        refused(server.get(&target), expected, way);
    }
    let Server { host, root, .. } = server;
    let port = host.split_once(':').unwrap().1;
    for foreign in [
        "",
        "Host: example.org\r\n",
        "Host: 127.0.0.1\r\n",
        "Host: 0.0.0.0\r\n",
        &format!("Host: example.org:{port}\r\n"),
        &format!("Host: {host}.example.org\r\n"),
        &format!("Host: {host}\r\nHost: example.org\r\n"),
    ] {
        let answer = server.exchange(format!("GET {root} HTTP/1.1\r\n{foreign}\r\n").as_bytes());
        refused(answer, 421, foreign);
    }
    for method in ["PUT", "DELETE", "OPTIONS", "PATCH", "CONNECT", "get"] {
        let request = format!("{method} {root} HTTP/1.1\r\nHost: {host}\r\n\r\n");
        refused(server.exchange(request.as_bytes()), 405, method);
    }
    for nonsense in [
        &b"\r\n\r\n"[..],
        b"GET\r\n\r\n",
        b"GET / SPDY/3\r\n\r\n",
        b"GET http://example.org/ HTTP/1.1\r\n\r\n",
        b"\x16\x03\x01\x02\x00\x01\r\n\r\n",
        &[b'a'; 40_000],
    ] {
        refused(server.exchange(nonsense), 400, "nonsense");
    }
    count
}

/// Opens a thousand connections that say nothing, and asks for something once the first are gone.
fn crowd(server: &Server) {
    // Those beyond the limit are closed at once; a process may hold about as many as there are here.
    let held: Vec<TcpStream> = (0..300).map(|_| server.connect()).collect();
    let mut closed = 0;
    for _ in 300..1000 {
        let mut stream = server.connect();
        stream.set_read_timeout(Some(Duration::from_secs(5))).unwrap();
        closed += usize::from(matches!(stream.read(&mut [0]), Ok(0) | Err(_)));
    }
    assert_eq!(closed, 700);
    drop(held);
    let begin = Instant::now();
    while !server.get(&server.root).starts_with("HTTP/1.1 200") {
        assert!(begin.elapsed() < Duration::from_secs(15), "no answer after the crowd");
        std::thread::sleep(Duration::from_millis(50));
    }
}

#[test]
fn view_gives_nothing_but_results() {
    let folder = lap("web-view");
    succeeds(
        &folder,
        &["run", "--benchmark", "brake-reuss-beam/brb-quick", "--out", "lap/run"],
    );
    let report = folder.join("lap/run/report.html");
    std::fs::remove_file(&report).unwrap();
    results(&folder.join("lap/run"));
    let server = Server::start(&folder, &["view", "lap/run", "--no-open"]);
    let mut count = refusals(&server, "1/");
    for target in [
        "/0/report.html",
        "/2/report.html",
        "/-1/report.html",
        "/report.html",
        "/1",
        "//1/report.html",
    ] {
        assert_eq!(status(&server.get(target)), 404, "{target}");
        count += 1;
    }
    let answer = server.post("", b"{}", |head| head);
    assert_eq!(status(&answer), 405);
    crowd(&server);
    println!("view: {} requests refused, 1000 connections", count + 1);
}

#[test]
fn setup_serves_its_own_page_alone() {
    let folder = lap("web-setup");
    results(&folder.join("lap/results/scene"));
    let server = Server::start(&folder, &["setup", "lap/scene.json", "--no-open"]);
    let page = server.get(&server.root);
    assert!(page.contains("Content-Security-Policy: default-src 'none'") && page.contains("connect-src 'self'"));
    let mut count = refusals(&server, "results/");
    let token = server.root.trim_matches('/').to_owned();
    assert_eq!(token.len(), 32);
    let flipped = token.replace(|c: char| c.is_ascii_digit(), "f");
    for wrong in [
        "",
        "/",
        "//",
        &token[1..],
        &token[..31],
        &format!("{token}0"),
        &token.to_uppercase(),
        &flipped,
    ] {
        if wrong == token {
            continue;
        }
        for name in ["", "progress", "results/report.html", "check"] {
            let answer = server.get(&format!("/{wrong}/{name}"));
            assert_eq!(status(&answer), 404, "{wrong}/{name}");
            let answer = server.post("", b"{}", |head| head.replace(&token, wrong));
            assert_eq!(status(&answer), 404, "POST {wrong}");
            count += 2;
        }
    }
    let host = &server.host;
    let own = format!("Origin: http://{host}\r\n");
    for foreign in [
        "".to_owned(),
        "Origin: null\r\n".into(),
        "Origin: http://example.org\r\n".into(),
        format!("Origin: https://{host}\r\n"),
        format!("Origin: http://{host}.example.org\r\n"),
        format!("{own}Origin: http://example.org\r\n"),
    ] {
        for action in ["check", "save", "run", "stop"] {
            let answer = server.post(action, b"{}", |head| head.replace(&own, &foreign));
            assert_eq!(status(&answer), 403, "{foreign}");
            count += 1;
        }
    }
    let length = "Content-Length: 2\r\n";
    for (from, to, expected) in [
        ("Content-Type: application/json", "Content-Type: text/plain", 415),
        (
            "Content-Type: application/json",
            "Content-Type: application/x-www-form-urlencoded",
            415,
        ),
        (length, "", 411),
        (length, "Transfer-Encoding: chunked\r\n", 411),
        (length, "Content-Length: 2\r\nTransfer-Encoding: chunked\r\n", 411),
        (length, "Content-Length: 2\r\nContent-Length: 2\r\n", 400),
        (length, "Content-Length: two\r\n", 400),
        (length, "Content-Length: 1048577\r\n", 413),
        (length, "Content-Length: 99999999999999999999999\r\n", 413),
        (&format!("Host: {host}"), "Host: example.org", 421),
    ] {
        let answer = server.post("save", b"{}", |head| head.replace(from, to));
        assert_eq!(status(&answer), expected, "{to}");
        count += 1;
    }
    // A body that is really there, and too large.
    let huge = vec![b' '; 8 << 20];
    assert_eq!(status(&server.post("check", &huge, |head| head)), 413);
    for malformed in [
        &b""[..],
        b"{",
        b"null",
        b"[]]",
        b"{\"scene\": 3}",
        b"{\"scene\": \"{}\", \"path\": \"/etc/passwd\"}",
        b"\xff\xfe",
        b"{\"replace\": \"yes\"}",
    ] {
        for action in ["check", "save", "run", "stop"] {
            assert_eq!(
                status(&server.post(action, malformed, |head| head)),
                400,
                "{malformed:?}"
            );
            count += 1;
        }
    }
    let deep = format!("{{\"scene\": {}}}", json!("[".repeat(500_000)));
    assert_eq!(
        server.send("check", &serde_json::from_str(&deep).unwrap())["complete"],
        false
    );
    assert_eq!(status(&server.get(&format!("{}run", server.root))), 405);
    assert_eq!(status(&server.get(&format!("{}progress?from=-1", server.root))), 400);
    crowd(&server);
    println!("setup: {} requests refused, 1000 connections", count + 4);
}

#[test]
#[ignore = "five to twenty seconds; `.ci/run slow` runs it"]
fn slow_requests_end_and_hold_nobody_up() {
    let folder = lap("web-slow");
    let server = Server::start(&folder, &["setup", "lap/mesh.msh", "--no-open"]);
    let head = format!(
        "POST {}check HTTP/1.1\r\nHost: {1}\r\nOrigin: http://{1}\r\nContent-Type: application/json\r\nContent-Length: 1000000\r\n\r\n",
        server.root, server.host
    );
    let begin = Instant::now();
    let limit = Duration::from_secs(19);
    std::thread::scope(|scope| {
        // One says nothing, one stops within its body, one sends a byte from time to time.
        for text in ["", &head] {
            let mut stream = server.connect();
            scope.spawn(move || {
                stream.write_all(text.as_bytes()).unwrap();
                stream.set_read_timeout(Some(limit)).unwrap();
                assert!(matches!(stream.read(&mut [0]), Ok(0)), "{text:.40}");
            });
        }
        let mut stream = server.connect();
        let head = &head;
        scope.spawn(move || {
            stream.write_all(head.as_bytes()).unwrap();
            while stream.write_all(b" ").is_ok() {
                assert!(begin.elapsed() < limit, "it is still listened to");
                std::thread::sleep(Duration::from_millis(200));
            }
        });
        for _ in 0..20 {
            assert_eq!(status(&server.get(&server.root)), 200);
            std::thread::sleep(Duration::from_millis(100));
        }
    });
}

#[test]
fn setup_says_what_is_missing_and_keeps_to_its_folder() {
    let folder = lap("web-check");
    let inside = folder.join("lap");
    let server = Server::start(&folder, &["setup", "lap/mesh.msh", "--no-open"]);
    let check = |scene: &Value| server.send("check", &json!({ "scene": scene.to_string() }));
    let given: Value = serde_json::from_str(&std::fs::read_to_string(inside.join("scene.json")).unwrap()).unwrap();
    let found = check(&given);
    assert_eq!((&found["complete"], &found["errors"]), (&json!(true), &json!([])));
    // Two bars of 180 x 25 x 8 mm, which touch over 60 x 25 mm.
    let density = 7857.8;
    for mass in found["echo"]["masses"].as_array().unwrap() {
        let expected = density * 0.18 * 0.025 * 0.008;
        assert!((mass.as_f64().unwrap() / expected - 1.0).abs() < 1e-2, "{mass}");
    }
    assert!((found["echo"]["areas"][0]["area"].as_f64().unwrap() / 1.5e-3 - 1.0).abs() < 1e-6);
    assert_eq!(found["echo"]["seats"].as_array().unwrap().len(), 4);
    // What a mesh cannot tell is asked for all at once, and what does not depend on it is told.
    let mut bare = given.clone();
    bare["interfaces"] = json!({});
    bare["bolts"] = json!({});
    bare["model"] = json!({});
    let found = check(&bare);
    let fields: Vec<&str> = found["errors"]
        .as_array()
        .unwrap()
        .iter()
        .map(|one| one["field"].as_str().unwrap())
        .collect();
    let expected = [
        "interfaces.mu",
        "bolts.load",
        "model.material.youngs_modulus",
        "model.material.poisson_ratio",
        "interfaces.surface",
        "model.material.density",
    ];
    assert_eq!(fields, expected);
    assert_eq!(found["echo"]["masses"], json!([]));
    assert!(found["echo"]["seats"][0]["covered"].as_f64().unwrap() > 0.5);
    // The fields alone are judged without the mesh.
    let quick = server.send("check", &json!({ "scene": bare.to_string(), "fields": true }));
    assert_eq!((&quick["errors"], &quick["echo"]), (&found["errors"], &Value::Null));
    bare.as_object_mut().unwrap().remove("units");
    assert_eq!(check(&bare)["errors"][0]["field"], "units");
    // Messages name the field that is wrong, beside what is missing.
    let mut wrong = given.clone();
    wrong["model"]["material"]["poisson_ratio"] = json!(0.7);
    assert_eq!(check(&wrong)["errors"][0]["field"], "model.material.poisson_ratio");
    for (path, remedy) in [
        ("../secret", "copy it there"),
        ("/etc/passwd", "copy it there"),
        ("x/../../secret", "copy it there"),
        ("missing.x3p", "missing.x3p"),
        ("link.x3p", "copy it there"),
    ] {
        #[cfg(unix)]
        let _ = std::os::unix::fs::symlink("../secret", inside.join("link.x3p"));
        let mut elsewhere = given.clone();
        elsewhere["interfaces"]["surface"] = json!({ "scans": [path, "mesh.msh"] });
        let found = check(&elsewhere);
        assert_eq!(found["errors"][0]["field"], "interfaces.surface.scans.0", "{found}");
        assert!(
            found["errors"][0]["message"].as_str().unwrap().contains(remedy),
            "{found}"
        );
        let run = server.send("run", &json!({ "scene": elsewhere.to_string(), "replace": true }));
        assert_eq!(run["complete"], false, "{run}");
        let mut elsewhere = given.clone();
        elsewhere["analyses"]["backbone"]["measured"] = json!([path]);
        let found = check(&elsewhere);
        assert_eq!(found["errors"][0]["field"], "analyses.backbone.measured", "{found}");
        assert!(
            found["errors"][0]["message"].as_str().unwrap().contains(remedy),
            "{found}"
        );
    }
    // A file that somebody else has written stays, unless its reader says otherwise.
    let before = std::fs::read(inside.join("scene.json")).unwrap();
    let save = |scene: &str, replace: bool| server.send("save", &json!({ "scene": scene, "replace": replace }));
    assert_eq!(save("{}", false), json!({ "exists": "scene.json" }));
    assert!(save("{", true)["error"].is_string());
    assert_eq!(std::fs::read(inside.join("scene.json")).unwrap(), before);
    let saved = json!({ "saved": "scene.json" });
    assert_eq!(save("{ \"a\": 1 }", true), saved);
    assert_eq!(save("{}", false), saved);
    let kept = || std::fs::read_to_string(inside.join("scene.json")).unwrap();
    assert_eq!(kept().trim(), "{}");
    // What stays keeps its comments, whoever has written them.
    let text = "{\n  // Of steel.\n  \"a\": 1, // one\n  \"b\": 2\n}\n";
    std::fs::write(inside.join("scene.json"), text).unwrap();
    assert_eq!(save("{ \"a\": 1, \"b\": 3 }", true), saved);
    assert_eq!(kept(), text.replace('2', "3"));
    std::fs::write(inside.join("scene.json"), "of somebody else").unwrap();
    assert_eq!(save("{}", false), json!({ "exists": "scene.json" }));
    assert_eq!(std::fs::read_to_string(folder.join("secret")).unwrap(), "hidden");
}

#[test]
fn runs_of_a_setup_are_one_at_a_time_and_can_be_stopped_and_resumed() {
    let folder = lap("web-run");
    let server = Server::start(&folder, &["setup", "lap/scene.json", "--no-open"]);
    let scene = std::fs::read_to_string(folder.join("lap/scene.json")).unwrap();
    let run = json!({ "scene": scene, "replace": true });
    let begun: usize = std::thread::scope(|scope| {
        let asked: Vec<_> = (0..8).map(|_| scope.spawn(|| server.send("run", &run))).collect();
        let answers = asked.into_iter().map(|one| one.join().unwrap());
        answers.filter(|answer| answer["saved"].is_string()).count()
    });
    assert_eq!(begun, 1);
    server.send("stop", &json!({}));
    let stopped = server.end();
    assert_eq!(
        (&stopped["end"]["stopped"], &stopped["end"]["code"]),
        (&json!(true), &Value::Null)
    );
    assert!(!folder.join("lap/results/scene/summary.json").exists());
    assert!(server.send("run", &run)["saved"].is_string());
    let told = server.end();
    assert_eq!(told["end"]["code"], 0, "{told}");
    let points = told["events"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|event| event["event"] == "point");
    let scene: Value = serde_json::from_str(&scene).unwrap();
    assert_eq!(
        points.count(),
        scene["analyses"]["backbone"]["amplitudes"].as_u64().unwrap() as usize
    );
    assert!(told["end"]["answer"].as_str().unwrap().contains("mode 1: "), "{told}");
    let report = server.get(&format!("{}results/report.html", server.root));
    assert_eq!(status(&report), 200);
}

#[test]
fn the_page_of_a_setup_has_the_bodies_with_what_touches() {
    let folder = lap("web-page");
    let server = Server::start(&folder, &["setup", "lap/mesh.msh", "--length", "m", "--no-open"]);
    let page = server.get(&server.root);
    let data: Value = serde_json::from_str(data_of(&page)).unwrap();
    let (facts, shape) = (&data["facts"], &data["shape"]);
    assert_eq!(
        (&facts["mesh"], &facts["length"], &facts["scene_file"]),
        (&json!("mesh.msh"), &json!("m"), &json!("scene.json"))
    );
    assert_eq!(facts["touching"][0]["entry"]["between"], json!(["bar 1", "bar 2"]));
    let numbers = |name: &str| -> Vec<u32> {
        let bytes = STANDARD.decode(shape[name].as_str().unwrap()).unwrap();
        bytes
            .chunks(4)
            .map(|four| u32::from_le_bytes(four.try_into().unwrap()))
            .collect()
    };
    let (bodies, patches, touching) = (numbers("bodies"), numbers("patches"), numbers("touching"));
    let of = |all: &[u32]| all.iter().collect::<BTreeSet<_>>().len();
    // Two bars of six plane sides, which touch on 12 x 6 elements each.
    assert_eq!((of(&bodies), of(&patches)), (2, 12));
    assert_eq!(touching.iter().filter(|pair| **pair == 1).count(), 2 * 72);
    assert!(touching.iter().all(|pair| *pair <= 1));
    // Two triangles of each quadrilateral.
    assert_eq!(numbers("face_of_triangle").len(), 2 * bodies.len());
    assert_eq!(numbers("triangles").len(), 6 * bodies.len());
    assert_eq!(shape["named"][0][0], "first end");
    // Beside a link to a mesh is where the link is.
    #[cfg(unix)]
    {
        std::fs::create_dir(folder.join("links")).unwrap();
        std::os::unix::fs::symlink("../lap/mesh.msh", folder.join("links/mesh.msh")).unwrap();
        let server = Server::start(&folder, &["setup", "links/mesh.msh", "--no-open"]);
        assert_eq!(
            server.send("save", &json!({ "scene": "{}" })),
            json!({ "saved": "scene.json" })
        );
        assert!(folder.join("links/scene.json").is_file());
    }
    // What a mesh is not is said.
    for (arguments, said) in [
        (&["setup", "secret", "--no-open"][..], "extension is not that of a mesh"),
        (&["setup", "missing.json", "--no-open"], "missing.json"),
        (
            &["setup", "lap/scene.json", "--length", "mm", "--no-open"],
            "leave --length out",
        ),
    ] {
        let output = run(&folder, arguments);
        assert!(
            exit_code(&output) == 1 && messages(&output).contains(said),
            "{}",
            messages(&output)
        );
    }
}
