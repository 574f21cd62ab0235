//! Crowds: clients that come and go, and clients that never finish their requests. Afterwards nothing is left of them.

use crate::common::service::{Answer, PATIENCE, Service, request};
use crate::common::{BALL, SLOW};
use std::io::{Read, Write};
use std::net::TcpStream;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

/// What the service has of the machine (Linux tells).
#[derive(Debug, Clone, Copy)]
struct Holdings {
    files: usize,
    threads: u64,
    /// Resident bytes.
    memory: u64,
}

impl Holdings {
    fn of(service: &Service) -> Self {
        let folder = format!("/proc/{}", service.pid());
        let files = std::fs::read_dir(format!("{folder}/fd")).unwrap().count();
        let status = std::fs::read_to_string(format!("{folder}/status")).unwrap();
        let number = |name: &str| -> u64 {
            let line = status.lines().find_map(|line| line.strip_prefix(name)).unwrap();
            line.trim_start_matches(':').trim().trim_end_matches(" kB").parse().unwrap()
        };
        Self { files, threads: number("Threads"), memory: number("VmRSS") << 10 }
    }
}

pub(crate) fn until(what: &str, mut condition: impl FnMut() -> bool) {
    let started = Instant::now();
    while !condition() {
        assert!(started.elapsed() < PATIENCE, "{what}");
        thread::sleep(Duration::from_millis(10));
    }
}

/// Clients that leave at any point: before they have said anything, within their headers, within their body, while they
/// wait, and while they are being rendered for. Every tenth asks for a job, which outlives it.
fn come_and_go(service: &Service, clients: usize) {
    let headers = [("Content-Type", "application/json")];
    let whole = request("POST", "/v1/render", &headers, SLOW.as_bytes());
    let job = format!(r#"{{"scene": {BALL}}}"#);
    let job = request("POST", "/v1/jobs", &headers, job.as_bytes());
    for number in 0..clients {
        let mut stream = service.connect();
        let (bytes, patience) = match number % 10 {
            0 => (&whole[..0], 0),
            1 => (&whole[..50], 0),
            2 => (&whole[..whole.len() - 100], 0),
            3 => (&whole[..], 5),
            4 => (&job[..], 0),
            _ => (&whole[..], 0),
        };
        // It may have been refused already, if the queue is full.
        let _ = stream.write_all(bytes);
        thread::sleep(Duration::from_millis(patience));
    }
}

fn is_idle(service: &Service) -> bool {
    let ready = service.get("/readyz").json();
    [&ready["running"], &ready["waiting"], &ready["jobs"]["running"], &ready["jobs"]["waiting"]]
        .iter()
        .all(|n| **n == 0)
}

#[test]
fn a_thousand_clients_that_leave_leave_nothing_behind() {
    let service = Service::start(&[]);
    // What the first crowd allocates stays with the allocator.
    thread::scope(|scope| (0..10).for_each(|_| _ = scope.spawn(|| come_and_go(&service, 20))));
    until("work goes on that nobody waits for", || is_idle(&service));
    let before = Holdings::of(&service);

    let flooding = AtomicBool::new(true);
    thread::scope(|scope| {
        scope.spawn(|| {
            while flooding.load(Ordering::Relaxed) {
                assert_eq!(service.get("/livez").status, 200);
                thread::sleep(Duration::from_millis(5));
            }
        });
        let crowd: Vec<_> = (0..10).map(|_| scope.spawn(|| come_and_go(&service, 100))).collect();
        crowd.into_iter().for_each(|part| part.join().unwrap());
        flooding.store(false, Ordering::Relaxed);
    });

    until("work goes on that nobody waits for", || is_idle(&service));
    until("files stay open", || Holdings::of(&service).files <= before.files + 1);
    // But for the sets that stay idle for renders that take turns, eight at most.
    let idle = 8 * thread::available_parallelism().unwrap().get() as u64;
    until("threads stay", || Holdings::of(&service).threads <= before.threads + idle);
    let after = Holdings::of(&service);
    println!("1,000 clients: {before:?} became {after:?}");
    assert!(after.memory < before.memory + (32 << 20), "{before:?} became {after:?}");
    service.post_json("/v1/render", BALL).picture();
    assert!(!service.log().contains("ERROR") && !service.log().contains("panicked"), "{}", service.log());
}

#[test]
fn clients_that_never_finish_their_headers_are_dropped_and_keep_nobody_out() {
    let service = Service::start(&["--header-timeout", "1", "--max-connections", "300"]);
    let files = Holdings::of(&service).files;
    let started = Instant::now();
    let mut slow: Vec<TcpStream> = (0..200).map(|_| service.connect()).collect();
    for stream in &mut slow {
        stream.write_all(b"POST /v1/render HTTP/1.1\r\nHost: localhost\r\n").unwrap();
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
    until("connections stay open", || Holdings::of(&service).files <= files + 1);
}

#[test]
fn clients_that_never_finish_their_bodies_are_answered_and_keep_no_memory() {
    let service = Service::start(&["--body-timeout", "1"]);
    let headers = [("Content-Type", "application/json")];
    let whole = request("POST", "/v1/render", &headers, SLOW.as_bytes());
    let mut slow: Vec<TcpStream> = (0..100).map(|_| service.connect()).collect();
    for stream in &mut slow {
        stream.write_all(&whole[..whole.len() - 100]).unwrap();
    }
    service.post_json("/v1/render", BALL).picture();
    for stream in slow {
        Answer::read(stream).problem(408, "body-timeout");
    }
}

#[test]
fn idle_connections_keep_nobody_out() {
    let service = Service::start(&["--max-connections", "40", "--header-timeout", "600"]);
    let headers = [("Content-Type", "application/json")];
    let mut busy = service.connect();
    let whole = request("POST", "/v1/render", &headers, BALL.as_bytes());
    busy.write_all(&whole[..whole.len() - 10]).unwrap();
    service.get("/livez");
    let idle: Vec<TcpStream> = (0..200).map(|_| service.connect()).collect();
    let mut slow: Vec<TcpStream> = (0..200).map(|_| service.connect()).collect();
    for stream in &mut slow {
        // It may have given way to the next one already.
        let _ = stream.write_all(b"POST /v1/render HTTP/1.1\r\n");
    }
    service.post_json("/v1/render", BALL).picture();
    assert!(Holdings::of(&service).files < 40 + 60, "{:?}", Holdings::of(&service));
    busy.write_all(&whole[whole.len() - 10..]).unwrap();
    Answer::read(busy).picture();
    drop((idle, slow));
}

#[test]
fn an_address_has_its_share_of_connections() {
    let service = Service::start(&["--client-connections", "4", "--body-timeout", "60"]);
    let headers = [("Content-Type", "application/json"), ("Expect", "100-continue")];
    let whole = request("POST", "/v1/render", &headers, BALL.as_bytes());
    let mut busy: Vec<TcpStream> = (0..4).map(|_| service.connect()).collect();
    for stream in &mut busy {
        stream.write_all(&whole[..whole.len() - BALL.len()]).unwrap();
        // The service says so as soon as it wants the body.
        stream.read_exact(&mut [0; 25]).unwrap();
    }
    let is_served = || {
        let mut another = service.connect();
        let _ = another.write_all(&request("GET", "/livez", &[], b""));
        matches!(another.read(&mut [0; 1]), Ok(1))
    };
    assert!(!is_served(), "a fifth connection has a place");
    drop(busy.pop());
    until("the place of one that has left is not given to another", is_served);
}

/// The system takes no more of each answer than the network does.
#[test]
fn clients_that_do_not_read_large_answers_keep_nobody_waiting() {
    let service = Service::start(&["--write-timeout", "600"]);
    let large = service.post_json("/v1/render?format=pfm&width=1600&height=1000&antialias=false", BALL);
    let place = large.header("content-location").to_owned();
    let mut crowd: Vec<TcpStream> = (0..300).map(|_| service.connect()).collect();
    for stream in &mut crowd {
        stream.write_all(&request("GET", &place, &[], b"")).unwrap();
    }
    service.post_json("/v1/render", BALL).picture();
}
