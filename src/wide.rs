//! Loops that run with the widest vector instructions of the machine.
//!
//! Native builds are compiled for every processor of their kind and choose at run time, through pulp; wasm builds have their
//! instructions fixed. Additions and multiplications are not fused, so a kernel has the same result with all of them.

/// A loop over numbers. `run` must be marked `#[inline(always)]`, so as to be compiled anew for each set of instructions.
pub(crate) trait Kernel {
    /// What it computes.
    type Output;

    /// The loop.
    fn run(self) -> Self::Output;
}

/// Runs the kernel with the widest instructions.
#[cfg(not(target_arch = "wasm32"))]
pub(crate) fn widest<K: Kernel>(kernel: K) -> K::Output {
    struct Dispatch<K>(K);
    impl<K: Kernel> pulp::WithSimd for Dispatch<K> {
        type Output = K::Output;

        #[inline(always)]
        fn with_simd<S: pulp::Simd>(self, _: S) -> K::Output {
            self.0.run()
        }
    }
    pulp::Arch::new().dispatch(Dispatch(kernel))
}

/// Runs the kernel.
#[cfg(target_arch = "wasm32")]
pub(crate) fn widest<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
}
