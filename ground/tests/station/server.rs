//! The server with valid and with malicious clients.

use std::net::{IpAddr, SocketAddr, TcpStream};
use std::time::Duration;

use crate::common::{Client, Served, cycle, get, raw, serve, until};
use tungstenite::Message;

/// Flies a range of cycles, counted from the start of the server.
fn fly(served: &Served, cycles: std::ops::Range<u32>) {
    for number in cycles {
        let arrival_s = served.start_s + f64::from(number) / 33.0;
        served.receive(&cycle(number), arrival_s);
    }
}

#[test]
fn a_client_chooses_looks_records_retrieves_seeks_exports_and_marks() {
    let served = serve(None);
    fly(&served, 0..330);
    let mut client = Client::connect(&served, "").unwrap();
    let hello = client.observe("hello");
    assert!(hello["channels"].as_array().unwrap().len() >= 60);

    client.ask(r#"{"do":"watch","channels":["roll_deg","vel_n_mps"]}"#);
    let (from, to) = (served.start_s - 10.0, served.start_s + 11.0);
    client.ask(&format!(r#"{{"do":"view","id":7,"from":{from},"to":{to},"columns":100}}"#));
    let view = client.observe("view");
    assert_eq!(view["id"], 7);
    let shown = view["series"]["roll_deg"][0].as_array().unwrap().len();
    assert!((80..=402).contains(&shown), "{shown}");

    // The mode began with the first data, not with the client's connection.
    let since = &client.observe("state")["what"]["since"];
    let begun_s = since[0].as_f64().unwrap() - served.start_s;
    assert!(begun_s.abs() < 0.1 && since[1] == false, "{since}");

    client.ask(r#"{"do":"record","name":"hover 1"}"#);
    client.ask(r#"{"do":"mark","note":"trimmed"}"#);
    let mut marked = false;
    while !marked {
        let state = client.observe("state");
        marked = state["markers"].as_array().unwrap().iter().any(|one| one["note"] == "trimmed");
    }
    fly(&served, 330..430);
    let tick = client.observe("tick");
    assert!(tick["now"].as_array().unwrap().iter().filter(|value| !value.is_null()).count() >= 60);
    client.ask(r#"{"do":"stop"}"#);
    let recorded = client.observe("recorded");
    assert!(
        recorded["frames"].as_u64().unwrap() >= 200 && recorded["fault"].is_null(),
        "{recorded}"
    );

    client.ask(r#"{"do":"list"}"#);
    assert_eq!(client.observe("records")[0]["name"], "hover 1");
    client.ask(r#"{"do":"open","name":"hover 1"}"#);
    let state = loop {
        let state = client.observe("state");
        if !state["record"].is_null() {
            break state;
        }
    };
    assert_eq!(state["record"]["is_cut"], false);
    let span = [0, 1].map(|end| state["what"]["span"][end].as_f64().unwrap());
    assert!((2.9..3.2).contains(&(span[1] - span[0])), "{span:?}");
    client.ask(&format!(r#"{{"do":"seek","to":{}}}"#, span[0] + 1.0));
    client.ask(r#"{"do":"play","speed":2}"#);
    let tick = loop {
        let tick = client.observe("tick");
        if tick["t"].as_f64().unwrap() > span[0] + 1.5 {
            break tick;
        }
    };
    assert!(tick["t"].as_f64().unwrap() <= span[1]);

    let path = format!(
        "/export.csv?record=hover%201&channels=roll_deg,satellites&from={}&to={}",
        span[0], span[1]
    );
    let csv = get(&served, &path);
    assert!(csv.contains("t_s,roll_deg,satellites\n"), "{csv}");
    assert!((95..=104).contains(&csv.lines().filter(|line| line.ends_with(",9")).count()));
}

#[test]
fn names_that_lead_elsewhere_and_requests_that_are_none_change_nothing() {
    let served = serve(None);
    let mut client = Client::connect(&served, "").unwrap();
    for name in ["../../etc/passwd", "/tmp/x", "a/b", "..", "", "con", "x\\u0000", ".x", "a\\\\b"] {
        for verb in ["record", "open", "evaluate"] {
            client.ask(&format!(r#"{{"do":"{verb}","name":"{name}"}}"#));
            let error = client.observe("error");
            assert!(error.as_str().unwrap().contains("found"), "{verb} {name}: {error}");
        }
    }
    for request in [
        "nonsense",
        "[]",
        r#"{"do":"arm"}"#,
        r#"{"do":"seek","to":1}"#,
        r#"{"do":"stop"}"#,
        r#"{"do":"watch","channels":["rm -rf"]}"#,
        r#"{"do":"view","id":1,"from":1,"to":0,"columns":9}"#,
        r#"{"do":"open","name":"not there"}"#,
        r#"{"do":"evaluate","name":"not there"}"#,
    ] {
        client.ask(request);
        client.observe("error");
    }
    let paths = [
        "/results/../../etc/passwd",
        "/results/x/%2e%2e/%2e%2e/etc/passwd.html",
        "/..%2f..%2fetc/passwd",
        "/results/..%2f..%2f/etc/x.html",
        "/results/x//etc/passwd.html",
        "/main.js/..",
        "/Cargo.toml",
        "/export.csv?from=0&to=1&record=..%2f..%2fetc%2fpasswd",
        "/export.csv?from=nan&to=1",
        "/export.csv?from=0&to=1&channels=nonsense",
        "/export.csv",
    ];
    for path in paths {
        let answer = get(&served, path);
        assert!(answer.starts_with("HTTP/1.1 4"), "{path}: {answer}");
    }
    let left: Vec<_> = std::fs::read_dir(served.place.path().join("records")).unwrap().collect();
    assert!(left.is_empty(), "{left:?}");
}

#[test]
fn without_the_token_nothing_is_reported() {
    let token = "0123456789abcdef";
    let served = serve(Some(token));
    for query in [
        "",
        "?token=",
        "?token=0123456789abcdee",
        "?token=0123456789abcdef0",
        "?Token=0123456789abcdef",
    ] {
        assert!(Client::connect(&served, query).is_err(), "{query}");
        let path = format!(
            "/export.csv{}from=0&to=1",
            if query.is_empty() { "?".into() } else { format!("{query}&") }
        );
        assert!(get(&served, &path).starts_with("HTTP/1.1 403"), "{query}");
    }
    assert!(get(&served, "/results/x/estimate/report.html").starts_with("HTTP/1.1 403"));
    // A refused page can request the reason.
    let why = get(&served, "/socket?token=0123456789abcdee");
    assert!(why.starts_with("HTTP/1.1 403") && why.contains("found no token or a wrong"), "{why}");
    let good = get(&served, &format!("/socket?token={token}"));
    assert!(good.starts_with("HTTP/1.1 4") && !good.starts_with("HTTP/1.1 403"), "{good}");
    Client::connect(&served, &format!("?token={token}")).unwrap().observe("hello");
    let good = get(&served, &format!("/export.csv?from=0&to=1&token={token}"));
    assert!(good.starts_with("HTTP/1.1 200"), "{good}");
}

#[test]
fn pages_of_others_may_not_ask() {
    let served = serve(None);
    let host = served.address;
    let upgrade = |host: &str, origin: &str| {
        raw(
            &served,
            &format!(
                "GET /socket HTTP/1.1\r\nHost: {host}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\
                 Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n{origin}\r\n"
            ),
        )
    };
    let own = host.to_string();
    assert!(upgrade(&own, "Origin: http://evil.example\r\n").starts_with("HTTP/1.1 403"));
    assert!(upgrade("evil.example", "").starts_with("HTTP/1.1 403"));
    assert!(upgrade(&own, "Origin: null\r\n").starts_with("HTTP/1.1 403"));
    assert!(upgrade(&own, &format!("Origin: http://{host}\r\n")).starts_with("HTTP/1.1 101"));
    let page = get(&served, "/");
    for header in ["content-security-policy: default-src 'self'", "nosniff", "no-referrer"] {
        assert!(page.contains(header), "{header}: {page}");
    }
}

#[test]
fn what_is_too_long_or_too_much_ends_the_connection_and_nothing_else() {
    let served = serve(None);
    let mut other = Client::connect(&served, "").unwrap();

    let mut long = Client::connect(&served, "").unwrap();
    let _ = long.0.send(Message::text("x".repeat(1 << 20)));
    assert!((0..10_000).any(|_| long.0.read().is_err()));

    let mut flood = Client::connect(&served, "").unwrap();
    for _ in 0..5_000 {
        if flood.0.send(Message::text(r#"{"do":"pause"}"#)).is_err() {
            break;
        }
    }
    assert!((0..10_000).any(|_| flood.0.read().is_err()));

    let mut pings = Client::connect(&served, "").unwrap();
    let ended = (0..20_000).any(|_| pings.0.send(Message::Ping(vec![1; 100].into())).is_err());
    assert!(ended || (0..10_000).any(|_| pings.0.read().is_err()));

    let mut binary = Client::connect(&served, "").unwrap();
    binary.0.send(Message::binary(vec![0xFF; 4000])).unwrap();
    binary.observe("tick");
    // Garbage, a header without end, a request without end.
    assert!(raw(&served, "\0\0\0\0\r\n\r\n").len() < 300);
    let endless = format!("GET / HTTP/1.1\r\nX: {}\r\n\r\n", "x".repeat(1 << 20));
    assert!(!raw(&served, &endless).starts_with("HTTP/1.1 200"));

    fly(&served, 0..33);
    assert!(!other.observe("tick")["now"].as_array().unwrap().is_empty());
}

#[test]
fn twenty_clients_look_at_once_and_more_than_the_room_are_refused() {
    let served = serve(None);
    fly(&served, 0..33);
    let mut clients: Vec<_> = (0..20).map(|_| Client::connect(&served, "").unwrap()).collect();
    let (from, to) = (served.start_s, served.start_s + 1.0);
    let view = format!(r#"{{"do":"view","id":1,"from":{from},"to":{to},"columns":100}}"#);
    for client in &mut clients {
        client.ask(r#"{"do":"watch","channels":["roll_deg","pitch_deg","yaw_deg","vel_n_mps","vel_e_mps","vel_u_mps"]}"#);
        // Requests are handled in order: after the view, the channels are watched.
        client.ask(&view);
        client.observe("view");
        client.observe("tick");
    }
    fly(&served, 33..99);
    for client in &mut clients {
        let mut points = 0;
        while points < 30 {
            let tick = client.observe("tick");
            points += tick["points"]["roll_deg"][0].as_array().map_or(0, Vec::len);
        }
    }
    let more: Vec<_> = (0..14).map(|_| Client::connect(&served, "")).collect();
    let refused = more.iter().filter(|client| client.is_err()).count();
    assert_eq!(refused, 2, "32 in all");
    drop((clients, more));
    let again = (0..200).any(|_| {
        std::thread::sleep(Duration::from_millis(50));
        Client::connect(&served, "").is_ok()
    });
    assert!(again, "slots are freed");
}

/// A connection from another address of this computer.
#[cfg(target_os = "linux")]
fn connect_from(served: &Served, last: u8) -> Option<TcpStream> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_io().build().unwrap();
    let stream = runtime.block_on(async {
        let socket = tokio::net::TcpSocket::new_v4()?;
        socket.bind(SocketAddr::new(IpAddr::from([127, 0, 0, last]), 0))?;
        socket.connect(served.address).await?.into_std()
    });
    let stream = stream.ok()?;
    stream.set_nonblocking(false).unwrap();
    Some(stream)
}

#[test]
#[cfg(target_os = "linux")]
fn two_addresses_that_hold_every_connection_and_every_place_do_not_shut_out_the_operator() {
    let served = serve(None);
    fly(&served, 0..33);
    let client = |last| {
        let url = format!("ws://{}/socket", served.address);
        Some(Client(tungstenite::client(url, connect_from(&served, last)?).ok()?.0))
    };
    let clients: Vec<_> = (0..16).flat_map(|_| [client(2), client(3)]).collect();
    assert_eq!(clients.iter().flatten().count(), 32);
    // Many more connections than there is room for.
    let idle: Vec<_> =
        (0..200).flat_map(|_| [2, 3]).map(|last| connect_from(&served, last)).collect();
    assert!(get(&served, "/").starts_with("HTTP/1.1 200"));
    let mut operator = Client::connect(&served, "").unwrap();
    assert!(!operator.observe("tick")["now"].as_array().unwrap().is_empty());
    drop((clients, idle));
}

#[test]
fn a_client_that_does_not_read_loses_its_place() {
    let served = serve(None);
    fly(&served, 0..330);
    let mut deaf: Vec<_> = (0..32).map(|_| Client::connect(&served, "").unwrap()).collect();
    assert!(Client::connect(&served, "").is_err());
    let all: Vec<_> = hovernav_ground::channel::CHANNELS.iter().map(|one| one.name).collect();
    let (from, to) = (served.start_s, served.start_s + 10.0);
    for client in &mut deaf {
        client.ask(&serde_json::json!({"do": "watch", "channels": all[..48]}).to_string());
        for id in 0..200 {
            let view = serde_json::json!({"do": "view", "id": id, "from": from, "to": to, "columns": 2000});
            // The server may have closed the connection already.
            let _ = client.0.send(Message::text(view.to_string()));
        }
    }
    until("a place is free", || Client::connect(&served, "").is_ok());
}

#[test]
#[cfg(unix)]
fn a_pipe_or_a_device_among_the_records_is_neither_listed_nor_opened() {
    let served = serve(None);
    let folder = served.place.path().join("records");
    let made = std::process::Command::new("mkfifo").arg(folder.join("pipe.mcap")).status();
    if !made.is_ok_and(|status| status.success()) {
        return hovernav_testing::skip("mkfifo does not start");
    }
    std::os::unix::fs::symlink("/dev/zero", folder.join("device.mcap")).unwrap();
    std::os::unix::fs::symlink(folder.join("pipe.mcap"), folder.join("link.mcap")).unwrap();
    std::fs::create_dir_all(folder.join("flight.results/estimate")).unwrap();
    std::os::unix::fs::symlink(
        folder.join("pipe.mcap"),
        folder.join("flight.results/estimate/report.html"),
    )
    .unwrap();
    let mut client = Client::connect(&served, "").unwrap();
    client.ask(r#"{"do":"list"}"#);
    assert_eq!(client.observe("records"), serde_json::json!([]));
    for name in ["pipe", "device", "link"] {
        for verb in ["open", "evaluate"] {
            client.ask(&serde_json::json!({"do": verb, "name": name}).to_string());
            let error = client.observe("error");
            let expected = if verb == "open" { "found a pipe or a device" } else { "" };
            assert!(error.as_str().unwrap().contains(expected), "{verb} {name}: {error}");
        }
        let export = format!("/export.csv?record={name}&from=0&to=1");
        assert!(get(&served, &export).starts_with("HTTP/1.1 400"));
    }
    let page = get(&served, "/results/flight/estimate/report.html");
    assert!(page.starts_with("HTTP/1.1 404"), "{page}");
}
