//! How many connections there may be, of all clients and of each address. Those that do nothing give way to new ones, so
//! that nobody keeps others out by opening many.

use super::activity::Activity;
use parking_lot::Mutex;
use std::cmp::Reverse;
use std::collections::HashMap;
use std::net::{IpAddr, Ipv6Addr};
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::Notify;
use tokio::time::timeout;

/// Addresses of IPv6 that differ only after so many bits belong to one client.
const NETWORK_BITS: u32 = 64;

/// A connection without a request gives way only after so long: its first one may be on its way.
const FRESH: Duration = Duration::from_millis(100);

/// The connections.
#[derive(Debug)]
pub(crate) struct ConnectionLimit {
    most: usize,
    /// Most connections of an address. None: a quarter of all, and no limit for loopback.
    of_address: Option<usize>,
    fresh: Duration,
    open: Mutex<Open>,
    left: Notify,
}

#[derive(Debug, Default)]
struct Open {
    connections: HashMap<u64, (IpAddr, Arc<Activity>)>,
    last: u64,
}

/// A connection, counted until this is dropped.
#[derive(Debug)]
pub(crate) struct Place {
    limit: Arc<ConnectionLimit>,
    number: u64,
}

impl Drop for Place {
    fn drop(&mut self) {
        self.limit.open.lock().connections.remove(&self.number);
        self.limit.left.notify_one();
    }
}

/// What becomes of a new connection.
#[derive(Debug)]
enum Admission {
    Admitted(Place),
    /// Its address has as many as it may have, and all are busy.
    Refused,
    /// There are as many as there may be, and all are busy.
    Full,
}

impl ConnectionLimit {
    /// At most `most` connections, and `of_address` from one address. Without that an address has a quarter, and loopback
    /// addresses, where proxies are, have no limit of their own.
    pub(crate) fn new(most: u32, of_address: Option<u32>) -> Self {
        let of_address = of_address.map(|most| most as usize);
        Self { most: most as usize, of_address, fresh: FRESH, open: Mutex::default(), left: Notify::new() }
    }

    /// Waits until there is a place for another connection; none if its address has all it may have.
    pub(crate) async fn admit(self: &Arc<Self>, address: IpAddr, activity: &Arc<Activity>) -> Option<Place> {
        loop {
            match self.try_admit(address, activity) {
                Admission::Admitted(place) => return Some(place),
                Admission::Refused => return None,
                Admission::Full => {
                    // One that has gone, or one that is idle by then.
                    let _ = timeout(FRESH, self.left.notified()).await;
                }
            }
        }
    }

    fn try_admit(self: &Arc<Self>, address: IpAddr, activity: &Arc<Activity>) -> Admission {
        let client = client(address);
        let mut open = self.open.lock();
        let share = self.of_address.or((!client.is_loopback()).then(|| self.most.div_ceil(4)));
        if share.is_some_and(|share| open.count(client) >= share)
            && !open.close_idle(self.fresh, |address| address == client)
        {
            return Admission::Refused;
        }
        if open.connections.len() >= self.most && !open.close_idle(self.fresh, |_| true) {
            return Admission::Full;
        }
        open.last += 1;
        let number = open.last;
        open.connections.insert(number, (client, Arc::clone(activity)));
        Admission::Admitted(Place { limit: Arc::clone(self), number })
    }
}

impl Open {
    fn count(&self, client: IpAddr) -> usize {
        self.connections.values().filter(|(address, _)| *address == client).count()
    }

    /// Closes a connection that does nothing: of the addresses that are meant, one of the address that has most, and of these
    /// the one that has done nothing for longest. False if there is none.
    fn close_idle(&mut self, fresh: Duration, is_meant: impl Fn(IpAddr) -> bool) -> bool {
        let mut counts: HashMap<IpAddr, usize> = HashMap::new();
        for (address, _) in self.connections.values() {
            *counts.entry(*address).or_default() += 1;
        }
        let idle =
            self.connections.iter().filter(|(_, (address, _))| is_meant(*address)).filter_map(|(number, place)| {
                let since = place.1.idle_since().filter(|since| since.elapsed() >= fresh)?;
                Some((counts[&place.0], Reverse(since), *number))
            });
        let Some((_, _, number)) = idle.max() else { return false };
        if let Some((_, activity)) = self.connections.remove(&number) {
            activity.close();
        }
        true
    }
}

/// Who an address belongs to.
fn client(address: IpAddr) -> IpAddr {
    match address.to_canonical() {
        IpAddr::V6(address) if !address.is_loopback() => {
            Ipv6Addr::from_bits(address.to_bits() & (u128::MAX << (128 - NETWORK_BITS))).into()
        }
        address => address,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::http::Request;

    /// A limit by which idle connections give way at once.
    fn at_once(most: u32, of_address: Option<u32>) -> Arc<ConnectionLimit> {
        Arc::new(ConnectionLimit { fresh: Duration::ZERO, ..ConnectionLimit::new(most, of_address) })
    }

    fn address(text: &str) -> IpAddr {
        text.parse().unwrap()
    }

    /// A connection of an address, if there is a place for one.
    fn connect(limit: &Arc<ConnectionLimit>, from: &str) -> Option<(Arc<Activity>, Place)> {
        let activity = Arc::default();
        match limit.try_admit(address(from), &activity) {
            Admission::Admitted(place) => Some((activity, place)),
            Admission::Refused | Admission::Full => None,
        }
    }

    fn is_open(limit: &ConnectionLimit, (_, place): &(Arc<Activity>, Place)) -> bool {
        limit.open.lock().connections.contains_key(&place.number)
    }

    #[test]
    fn idle_connections_give_way_and_busy_ones_stay() {
        let limit = at_once(3, None);
        assert!((0..3).all(|_| connect(&limit, "127.0.0.1").is_some()), "places are given back");
        let open: Vec<_> = (0..3).map(|_| connect(&limit, "127.0.0.1").unwrap()).collect();
        let first = open[0].0.begin(&Request::new(()));
        let another = connect(&limit, "127.0.0.1").unwrap();
        assert_eq!([0, 1, 2].map(|at| is_open(&limit, &open[at])), [true, false, true], "the longest idle has gone");
        let _busy = [open[2].0.begin(&Request::new(())), another.0.begin(&Request::new(()))];
        assert!(connect(&limit, "127.0.0.1").is_none(), "all are busy");
        drop(first);
        assert!(connect(&limit, "127.0.0.1").is_some() && !is_open(&limit, &open[0]));
    }

    #[test]
    fn an_address_has_its_share_and_loses_its_own() {
        let limit = at_once(8, None);
        let quiet = connect(&limit, "10.0.0.1").unwrap();
        let greedy: Vec<_> = (0..2).map(|_| connect(&limit, "10.0.0.2").unwrap()).collect();
        let third = connect(&limit, "10.0.0.2").unwrap();
        assert_eq!(
            [is_open(&limit, &quiet), is_open(&limit, &greedy[0]), is_open(&limit, &greedy[1])],
            [true, false, true]
        );
        let _busy = [greedy[1].0.begin(&Request::new(())), third.0.begin(&Request::new(()))];
        assert!(connect(&limit, "10.0.0.2").is_none() && connect(&limit, "::ffff:10.0.0.2").is_none());
        assert!(connect(&limit, "10.0.0.3").is_some());

        let limit = at_once(8, None);
        let of_networks: Vec<_> =
            ["2001:db8::1", "2001:db8::2", "2001:db8:0:1::1"].map(|from| connect(&limit, from)).into();
        let _third = connect(&limit, "2001:db8::3").unwrap();
        let open: Vec<_> = of_networks.iter().flatten().map(|connection| is_open(&limit, connection)).collect();
        assert_eq!(open, [false, true, true], "a network of 64 bits is one client");
    }

    #[test]
    fn where_all_are_taken_the_address_with_most_gives_way() {
        let limit = at_once(3, Some(2));
        let oldest = connect(&limit, "10.0.0.1").unwrap();
        let greedy: Vec<_> = (0..2).map(|_| connect(&limit, "10.0.0.2").unwrap()).collect();
        assert!(connect(&limit, "10.0.0.3").is_some());
        assert!(is_open(&limit, &oldest) && !is_open(&limit, &greedy[0]) && is_open(&limit, &greedy[1]));
    }
}
