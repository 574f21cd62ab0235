//! Users of the broker with as few rights as fronts and nodes can work with.
//!
//! A node takes work, reports, and gives results: it cannot hand out work, take back that of others, read records of jobs or
//! hear what the broker answers to anybody else. Fronts own all that the farm has at the broker.

use super::names::{self, NODES, RESULTS, WORK};
use std::fmt::Write;

/// A user of the broker.
#[derive(Debug, Clone)]
pub(crate) struct User {
    /// Its public key. Only the owner of the seed can sign in with it.
    pub(crate) public_key: String,
    /// The first part of the subjects on which it is answered.
    pub(crate) inbox: String,
    /// What it does.
    pub(crate) role: Role,
}

/// What a user does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Role {
    /// Answers clients and hands out work.
    Front,
    /// Renders.
    Node,
}

impl Role {
    /// Subjects that it may publish to.
    fn publishes(self, inbox: &str) -> Vec<String> {
        let owned = |subjects: &[&str]| subjects.iter().map(|&subject| subject.to_owned()).collect();
        match self {
            // The account is the farm's alone, so the whole interface of streams may be a front's. Fronts answer each other.
            Self::Front => {
                let mut all: Vec<String> = owned(&["$JS.API.>", "$JS.ACK.>", "$JS.FC.>", "$KV.>", names::BY_FRONTS]);
                all.push(format!("{inbox}.>"));
                all
            }
            Self::Node => {
                let mut all: Vec<String> = owned(&names::BY_NODES);
                all.extend([
                    format!("$JS.API.STREAM.INFO.{WORK}"),
                    format!("$JS.API.CONSUMER.INFO.{WORK}.*"),
                    format!("$JS.API.CONSUMER.MSG.NEXT.{WORK}.*"),
                    format!("$JS.ACK.{WORK}.>"),
                    // What another node has stored is compared with one's own.
                    format!("$JS.API.STREAM.INFO.{RESULTS}"),
                    format!("$JS.API.DIRECT.GET.{RESULTS}.>"),
                    format!("$JS.API.STREAM.INFO.KV_{NODES}"),
                    format!("$KV.{NODES}.>"),
                ]);
                all
            }
        }
    }

    /// Subjects that it may listen to.
    fn hears(self, inbox: &str) -> Vec<String> {
        let others: &[&str] = match self {
            Self::Front => &[names::BY_FRONTS, names::TOO_OFTEN],
            Self::Node => &[names::TO_NODES],
        };
        [format!("{inbox}.>")].into_iter().chain(others.iter().map(|&subject| subject.to_owned())).collect()
    }
}

/// The broker's configuration of these users, which its own configuration includes.
pub(crate) fn configuration(users: &[User]) -> String {
    let mut text = "\
# Users of a farm, made by `strahl farm accounts`: nobody else may sign in. The keys are public ones, so nothing here is secret.
# Run the command again after an upgrade: it keeps the secrets, and writes the rights that the new version needs.
accounts {
  STRAHL {
    jetstream: enabled
    users: [
"
    .to_owned();
    for user in users {
        let list = |subjects: Vec<String>| {
            subjects.iter().map(|subject| format!("            {subject:?}\n")).collect::<String>()
        };
        // Writing to a String cannot fail.
        _ = write!(
            text,
            "      {{\n        nkey: {}\n        permissions: {{\n          publish: {{ allow: [\n{}          ] }}\n          \
             subscribe: {{ allow: [\n{}          ] }}\n        }}\n      }}\n",
            user.public_key,
            list(user.role.publishes(&user.inbox)),
            list(user.role.hears(&user.inbox)),
        );
    }
    text + "    ]\n  }\n}\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether a subject is one of a pattern.
    fn matches(pattern: &str, subject: &str) -> bool {
        let (mut pattern, mut subject) = (pattern.split('.'), subject.split('.'));
        loop {
            match (pattern.next(), subject.next()) {
                (Some(">"), Some(_)) | (None, None) => return true,
                (Some(a), Some(b)) if a == "*" || a == b => {}
                _ => return false,
            }
        }
    }

    fn may(role: Role, subject: &str) -> bool {
        role.publishes("_INBOX.x").iter().any(|pattern| matches(pattern, subject))
    }

    #[test]
    fn nodes_may_do_their_work_and_nothing_else() {
        let work = names::work(names::Class::Norm, "a", "7");
        let next = format!("$JS.API.CONSUMER.MSG.NEXT.{WORK}.{}", names::Class::Hi.queue());
        for subject in [names::result("7", 3), names::begun("7"), names::dead("a.b", "7"), next] {
            assert!(may(Role::Node, &subject), "{subject}");
        }
        let purge = format!("$JS.API.STREAM.PURGE.{WORK}");
        let read = format!("$JS.API.DIRECT.GET.KV_{}.a.7", names::JOBS);
        let record = format!("$KV.{}.{}", names::JOBS, names::job_key("a", "7"));
        for subject in
            [work, purge, read, record, names::cancel("7"), names::events("7"), "$JS.API.STREAM.CREATE.X".into()]
        {
            assert!(!may(Role::Node, &subject), "{subject}");
            assert!(may(Role::Front, &subject), "{subject}");
        }
        assert!(!may(Role::Front, "$SYS.REQ.SERVER.PING"));
    }

    #[test]
    fn nobody_hears_the_answers_to_others() {
        let hears =
            |role: Role, inbox: &str, subject: &str| role.hears(inbox).iter().any(|pattern| matches(pattern, subject));
        assert!(hears(Role::Node, "_INBOX.node", "_INBOX.node.x.1"));
        assert!(!hears(Role::Node, "_INBOX.node", "_INBOX.front.x.1"));
        assert!(!hears(Role::Node, "_INBOX.node", &names::work(names::Class::Hi, "a", "7")));
        assert!(!hears(Role::Front, "_INBOX.front", "_INBOX.node.x.1"));
    }
}
