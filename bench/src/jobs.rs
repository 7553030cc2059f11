//! Independent pieces of work side by side.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use tracecut_cli::failure::Result;

/// Calls `work` on every item, up to `jobs` at a time, and `report` on every result in the items' order as soon as it
/// and all before it are there. Ends at the first failure in that order.
pub(crate) fn in_order<I: Sync, O: Send>(
    items: &[I],
    jobs: usize,
    work: impl Fn(&I) -> Result<O> + Sync,
    report: impl Fn(&O) -> Result<()>,
) -> Result<Vec<O>> {
    let next = AtomicUsize::new(0);
    let (sender, receiver) = mpsc::channel();
    std::thread::scope(|scope| {
        for _ in 0..jobs.min(items.len()) {
            let (sender, next, work) = (sender.clone(), &next, &work);
            scope.spawn(move || {
                while let Some((index, item)) = items.iter().enumerate().nth(next.fetch_add(1, Ordering::Relaxed)) {
                    if sender.send((index, work(item))).is_err() {
                        return;
                    }
                }
            });
        }
        drop(sender);
        let mut waiting: Vec<Option<Result<O>>> = items.iter().map(|_| None).collect();
        let mut done = Vec::new();
        for (index, result) in receiver {
            waiting[index] = Some(result);
            while let Some(result) = waiting.get_mut(done.len()).and_then(Option::take) {
                // On a failure the receiver is dropped, and the threads end after the sequence at hand.
                let result = result?;
                report(&result)?;
                done.push(result);
            }
        }
        Ok(done)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;
    use tracecut_cli::failure::Failure;

    #[test]
    fn results_come_in_the_order_of_the_items_whatever_finishes_first() {
        let items: Vec<u64> = vec![30, 1, 20, 0, 10];
        let seen = Mutex::new(Vec::new());
        let work = |&ms: &u64| {
            std::thread::sleep(std::time::Duration::from_millis(ms));
            Ok(ms)
        };
        let report = |&ms: &u64| {
            seen.lock().unwrap().push(ms);
            Ok(())
        };
        let all = in_order(&items, 3, work, report).unwrap();
        assert_eq!((&all, &*seen.lock().unwrap()), (&items, &items));
    }

    #[test]
    fn the_first_failure_in_order_ends_the_run() {
        let work = |&n: &u32| if n >= 2 { Err(Failure::new(format!("item {n}"))) } else { Ok(n) };
        let failure = in_order(&[0, 1, 2, 3], 2, work, |_| Ok(())).unwrap_err();
        assert_eq!(failure.reason, "item 2");
        assert!(in_order(&[] as &[u32], 2, work, |_| Ok(())).unwrap().is_empty());
    }
}
