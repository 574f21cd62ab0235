//! Three brokers that keep everything three times: one may end.

use crate::backends::{MIRRORS, alone};
use crate::common::service::Service;
use crate::harness::{Broker, Farm, LEASE, Node, free_port, wait_until};

/// T3, three brokers: the leader of the work is killed, and comes back.
#[test]
fn a_leader_that_is_killed_loses_nothing() {
    let routes = [(); 3].map(|()| free_port());
    let all = routes.map(|port| format!("nats://127.0.0.1:{port}")).join(",");
    let brokers: Vec<Broker> = (routes.iter())
        .filter_map(|port| {
            let name = format!("n{port}");
            let own = format!("nats://127.0.0.1:{port}");
            Broker::start_with(&["-n", &name, "--cluster_name", "farm", "--cluster", &own, "--routes", &all])
        })
        .collect();
    let Ok([one, two, three]) = <[Broker; 3]>::try_from(brokers) else { return };
    let url = [&one, &two, &three].map(Broker::url).join(",");
    let store = tempfile::tempdir().unwrap();
    let folder = store.path().to_str().unwrap().to_owned();
    let flags = ["--farm", &url, "--store", &folder, "--farm-lease", LEASE, "--farm-replicas", "3", "--threads", "1"];
    let front = Service::start(&flags);
    let nodes = ["one", "two"].map(|name| Node::start(&url, &folder, name, &[]));
    let farm = Farm { front, store, broker: one };
    let id = farm.submit("", MIRRORS);
    farm.wait_for_share(&id, 0.2);
    let leader = farm.broker.ask(async |broker| {
        let mut stream = broker.get_stream("FARM_T").await.unwrap();
        stream.info().await.unwrap().cluster.clone().unwrap().leader.unwrap()
    });
    let (mut others, mut farm) = ([two, three], farm);
    let at = routes.iter().position(|port| leader == format!("n{port}")).unwrap();
    let broker = if at == 0 { &mut farm.broker } else { &mut others[at - 1] };
    broker.kill();
    assert!(farm.picture(&id).body == alone("", MIRRORS), "{}", nodes[0].log());
    let broker = if at == 0 { &mut farm.broker } else { &mut others[at - 1] };
    broker.restart();
    wait_until("the queue is empty", || farm.broker.messages("FARM_T") == 0);
}
