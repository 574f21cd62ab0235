//! Crowds: clients that come and go, and clients that never finish their requests. Afterwards nothing is left of them.

use super::service::{Answer, Service, request};
use super::{BALL, SLOW};
use std::io::Write;
use std::net::TcpStream;
use std::thread;
use std::time::{Duration, Instant};

/// Open files and resident bytes of the service (Linux tells).
fn holds(service: &Service) -> (usize, u64) {
    let folder = format!("/proc/{}", service.pid());
    let files = std::fs::read_dir(format!("{folder}/fd")).unwrap().count();
    let status = std::fs::read_to_string(format!("{folder}/status")).unwrap();
    let kilobytes =
        status.lines().find_map(|line| line.strip_prefix("VmRSS:")?.trim().strip_suffix(" kB")?.parse().ok());
    (files, kilobytes.map_or(0, |kilobytes: u64| kilobytes << 10))
}

fn until(what: &str, mut condition: impl FnMut() -> bool) {
    let started = Instant::now();
    while !condition() {
        assert!(started.elapsed() < Duration::from_secs(20), "{what}");
        thread::sleep(Duration::from_millis(10));
    }
}

#[test]
fn a_thousand_clients_that_leave_leave_nothing_behind() {
    let service = Service::start(&[]);
    // What the first renders allocate stays with the allocator.
    for _ in 0..3 {
        drop(service.begin("/v1/render", SLOW));
    }
    service.wait_for(0, 0);
    let (files, memory) = holds(&service);
    for _ in 0..1_000 {
        drop(service.begin("/v1/render", SLOW));
    }
    service.wait_for(0, 0);
    until("files stay open", || holds(&service).0 <= files + 1);
    let (_, now) = holds(&service);
    assert!(now < memory + (64 << 20), "{memory} bytes became {now}");
    service.post_json("/v1/render", BALL).picture();
    assert!(!service.log().contains("ERROR") && !service.log().contains("panicked"), "{}", service.log());
}

#[test]
fn clients_that_never_finish_their_headers_are_dropped_and_keep_nobody_out() {
    let service = Service::start(&["--header-timeout", "1", "--max-connections", "300"]);
    let (files, _) = holds(&service);
    let started = Instant::now();
    let mut slow: Vec<TcpStream> = (0..200).map(|_| service.connect()).collect();
    for stream in &mut slow {
        stream.write_all(b"POST /v1/render HTTP/1.1\r\nHost: strahl\r\n").unwrap();
    }
    // One more byte now and then does not buy more time.
    while started.elapsed() < Duration::from_millis(2_500) {
        for stream in &mut slow {
            let _ = stream.write_all(b"X");
        }
        let mut other = service.connect();
        other.write_all(&request("GET", "/livez", &[], b"")).unwrap();
        assert_eq!(Answer::read(other).status, 200);
        thread::sleep(Duration::from_millis(100));
    }
    until("connections stay open", || holds(&service).0 <= files + 1);
}
