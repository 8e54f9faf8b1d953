//! Large pages for what rays read here and there: a processor knows the places of some thousand pages, which are 8 MB of
//! small ones and gigabytes of large ones.

use std::ffi::c_void;

/// Bytes of a large page, and least bytes for which it is asked.
const LARGE_PAGE: usize = 2 << 20;

/// Asks Linux to keep `items` in large pages from now on. Where it cannot, now or ever, nothing is different.
pub(super) fn enlarge<T>(items: &[T]) {
    let start = items.as_ptr().addr();
    let first = start.next_multiple_of(LARGE_PAGE);
    let length = ((start + size_of_val(items)) / LARGE_PAGE * LARGE_PAGE).saturating_sub(first);
    if length == 0 {
        return;
    }
    let pages: *mut c_void = items.as_ptr().wrapping_byte_add(first - start).cast_mut().cast();
    // SAFETY: the range lies within `items`; both advices change which pages hold it, and not what they hold. The second,
    // which does at once what the first allows to be done some time, is unknown before Linux 6.1.
    unsafe {
        libc::madvise(pages, length, libc::MADV_HUGEPAGE);
        libc::madvise(pages, length, libc::MADV_COLLAPSE);
    }
}
