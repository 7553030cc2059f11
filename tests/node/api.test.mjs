// The listing of a public interface, from a small library that has one of everything.

import assert from 'node:assert/strict';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { listApi } from '../../scripts/api/list.mjs';
import { describe } from '../../scripts/api/rustdoc.mjs';
import { type } from '../../scripts/api/signature.mjs';

/** Lines and count for a library's source. */
function listed(t, source) {
  const folder = mkdtempSync(join(tmpdir(), 'tracecut-api-'));
  t.after(() => rmSync(folder, { recursive: true }));
  const file = join(folder, 'lib.rs');
  writeFileSync(file, source);
  return listApi(describe(file, { name: 'small', edition: '2024', folder }));
}

test('each public item has a line, and nothing private has', (t) => {
  const { lines, count } = listed(
    t,
    `mod inner {
       pub struct Moved(pub u8, u16);
       pub fn not_seen() {}
       pub(crate) fn nor_this() {}
     }
     pub mod shown {
       #[derive(Clone, Debug)]
       #[non_exhaustive]
       pub struct Plane<T: Copy, const N: usize = 2> where T: Default {
         pub data: Vec<T>,
         hidden: [T; N],
       }
       impl<T: Copy + Default> Plane<T> {
         pub const EMPTY: u32 = 0;
         pub const fn len(&self) -> usize { 0 }
         pub fn rows<'a>(&'a mut self, of: impl Fn(&T) -> bool) -> Box<dyn Iterator<Item = &'a [T]> + 'a> { panic!() }
         fn own(&self) {}
       }
     }
     pub enum Error { Io(std::io::Error), Param { name: &'static str }, Other }
     impl From<std::io::Error> for Error { fn from(error: std::io::Error) -> Self { Error::Io(error) } }
     pub trait Verb: Send {
       type Output: ?Sized;
       fn act(&self, _: fn(i32) -> !) -> Option<&Self::Output> where Self: Sized;
     }
     pub type Pair = (f32, <u8 as std::str::FromStr>::Err);
     pub use inner::Moved;
     pub use shown::Plane;
     #[doc(hidden)] pub fn hidden() {}`,
  );
  assert.deepEqual(lines, [
    'mod small',
    'enum small::Error',
    'impl small::Error: From<Error>',
    'variant small::Error::Io(Error)',
    'variant small::Error::Other',
    'variant small::Error::Param',
    "field small::Error::Param::name: &'static str",
    'struct small::Moved(u8, _)',
    'type small::Pair = (f32, <u8 as FromStr>::Err)',
    'use small::Plane = small::shown::Plane',
    'trait small::Verb: Send',
    'type small::Verb::Output: ?Sized',
    'fn small::Verb::act(&self, fn(i32) -> !) -> Option<&Self::Output> where Self: Sized',
    'mod small::shown',
    '#[non_exhaustive] struct small::shown::Plane<T, const N: usize = 2> where T: Default + Copy',
    'const small::shown::Plane::EMPTY: u32',
    'field small::shown::Plane::data: Vec<T>',
    'const fn small::shown::Plane::len(&self) -> usize',
    "fn small::shown::Plane::rows<'a>(&'a mut self, of: impl Fn(&T) -> bool) -> Box<dyn Iterator<Item = &'a [T]> + 'a>",
    'impl small::shown::Plane<T, N>: Clone (where T: Default + Clone + Copy) + Debug (where T: Default + Debug + Copy)',
  ]);
  assert.equal(count, 12);
});

test('a kind that a later rustdoc brings is an error', () => {
  assert.equal(type({ borrowed_ref: { lifetime: null, is_mutable: false, type: { primitive: 'u8' } } }), '&u8');
  assert.throws(() => type({ pattern_of_tomorrow: {} }), /pattern_of_tomorrow/);
});
