//! The interface called from Rust: against the laws themselves, in place, from several threads, and with a law that
//! panics.

use std::ffi::CStr;
use std::ops::Range;
use std::ptr;

use contact_laws::*;

use crate::*;

const N: usize = 300;
const MU: f64 = 0.3;

/// Numbers in -1..1 by a linear congruential generator (Knuth, MMIX).
fn numbers(seed: u64, n: usize) -> Vec<f64> {
    let mut state = seed;
    (0..n)
        .map(|_| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        })
        .collect()
}

fn scaled(seed: u64, scale: f64) -> Vec<f64> {
    numbers(seed, N).into_iter().map(|v| scale * v).collect()
}

struct Input {
    jump: [Vec<f64>; 3],
    begin: Vec<f64>,
}

/// Open, closed, slipping and sticking points.
fn input() -> Input {
    let jump = [scaled(1, 5e-7), scaled(2, 5e-7), scaled(3, 2e-6)];
    let mut begin = [scaled(4, 5e-7), scaled(5, 5e-7), scaled(6, 2e-6)].concat();
    begin.extend([scaled(7, 1e5), scaled(8, 1e5)].concat());
    Input { jump, begin }
}

fn fit(point: usize) -> FittedCurves {
    let shift = 1e-3 * point as f64;
    let normal = NormalFit {
        a: 15.2 + shift,
        b: 2.2,
        c: -0.9,
        d: 0.3,
        e: 0.9,
        u_ref: 1e-6,
        t_ref: 1.0,
        range: Some([1e-7, 1e-5]),
    };
    let tangential = |a: f64| TangentialFit {
        a: a + shift,
        b: 1.4,
        c: 0.3,
        d: 0.6,
        u_ref: 1e-6,
        k_ref: 1.0,
        range: Some([1e-7, 1e-5]),
        ends: TangentialEnds::Mindlin,
    };
    FittedCurves::try_new(normal, [tangential(29.0), tangential(29.3)]).unwrap()
}

fn rust_law() -> RoughLaw {
    let curves = PointParameters::per_point((0..N).map(fit).collect());
    RoughLaw::try_new(
        FittedPoints::new(&curves),
        PointParameters::uniform(MU, N),
        HistoryRule::Incremental,
    )
    .unwrap()
}

struct Handle(*mut Law);

// SAFETY: laws are not bound to threads.
unsafe impl Sync for Handle {}

impl Drop for Handle {
    fn drop(&mut self) {
        // SAFETY: from a constructor, and freed here alone.
        unsafe { cl_law_free(self.0) };
    }
}

/// The law of [`rust_law`], made through the interface.
fn c_law() -> Handle {
    let column = |value: fn(&NormalFit) -> f64| (0..N).map(|p| value(fit(p).normal_fit())).collect::<Vec<_>>();
    let normal = [
        column(|f| f.a),
        column(|f| f.b),
        column(|f| f.c),
        column(|f| f.d),
        column(|f| f.e),
    ]
    .concat();
    let tangential = |q: usize| {
        let of =
            |value: fn(&TangentialFit) -> f64| (0..N).map(|p| value(&fit(p).tangential_fits()[q])).collect::<Vec<_>>();
        [of(|f| f.a), of(|f| f.b), of(|f| f.c), of(|f| f.d)].concat()
    };
    let (x, y) = (tangential(0), tangential(1));
    let (lower, upper) = (vec![1e-7; N], vec![1e-5; N]);
    let ranges = [&lower, &upper, &lower, &upper, &lower, &upper]
        .map(|r| r.as_slice())
        .concat();
    let mut message = [0_u8; 200];
    // SAFETY: all arrays have the documented lengths.
    let law = unsafe {
        cl_rough_law(
            N,
            normal.as_ptr(),
            x.as_ptr(),
            y.as_ptr(),
            column(|f| f.u_ref).as_ptr(),
            ranges.as_ptr(),
            N,
            TangentialEnds::Mindlin.number(),
            &MU,
            1,
            HistoryRule::Incremental.number(),
            message.as_mut_ptr().cast(),
            message.len(),
        )
    };
    assert!(!law.is_null(), "{:?}", CStr::from_bytes_until_nul(&message));
    Handle(law)
}

#[derive(Debug, PartialEq)]
struct Output {
    traction: [Vec<f64>; 3],
    tangent: [Vec<f64>; 9],
    end: Vec<f64>,
    regimes: Vec<i32>,
    counts: Counts,
}

impl Output {
    fn new() -> Self {
        Self {
            traction: [(); 3].map(|()| vec![0.0; N]),
            tangent: [(); 9].map(|()| vec![0.0; N]),
            end: vec![0.0; 5 * N],
            regimes: vec![-9; N],
            counts: Counts::default(),
        }
    }
}

fn by_rust(input: &Input) -> Output {
    let mut out = Output::new();
    let [tx, ty, tn] = &mut out.traction;
    let mut regimes = vec![Regime::Open; N];
    let counts = rust_law().evaluate(
        0..N,
        Sticking::Coulomb,
        Components::new(&input.jump[0], &input.jump[1], &input.jump[2]),
        StateView::new(&input.begin, N, 0),
        StateViewMut::new(&mut out.end, N, 0),
        ComponentsMut::new(tx, ty, tn),
        Some(TangentMut::from_entries(out.tangent.each_mut().map(Vec::as_mut_slice))),
        Some(&mut regimes),
    );
    out.counts = counts.into();
    for (code, regime) in out.regimes.iter_mut().zip(regimes) {
        *code = match regime {
            Regime::Stick => CL_REGIME_STICK,
            Regime::Slip => CL_REGIME_SLIP,
            Regime::Open => CL_REGIME_OPEN,
            Regime::Invalid => CL_REGIME_INVALID,
        };
    }
    out
}

/// Addresses of the arrays of an [`Output`], for several threads to write to.
struct Targets {
    traction: [*mut f64; 3],
    tangent: [*mut f64; 9],
    end: *mut f64,
    regimes: *mut i32,
}

// SAFETY: the tests let each thread write to points of its own.
unsafe impl Sync for Targets {}

impl Targets {
    fn new(out: &mut Output) -> Self {
        Self {
            traction: out.traction.each_mut().map(|t| t.as_mut_ptr()),
            tangent: out.tangent.each_mut().map(|t| t.as_mut_ptr()),
            end: out.end.as_mut_ptr(),
            regimes: out.regimes.as_mut_ptr(),
        }
    }
}

/// # Safety
/// `begin` and `end` are blocks of five components of `N` points, and nobody else uses these points.
unsafe fn call(law: &Handle, points: Range<usize>, jump: &[Vec<f64>; 3], begin: *const f64, to: &Targets) -> Counts {
    let (first, count) = (points.start, points.len());
    let mut counts = Counts::default();
    let mut message = [0_u8; 200];
    let at = |p: *mut f64| p.wrapping_add(first);
    let tangent = to.tangent.map(at);
    // SAFETY: `first + count` is at most `N`.
    let status = unsafe {
        cl_law_evaluate(
            law.0,
            first,
            count,
            Sticking::Coulomb.number(),
            jump[0].as_ptr().wrapping_add(first),
            jump[1].as_ptr().wrapping_add(first),
            jump[2].as_ptr().wrapping_add(first),
            begin.wrapping_add(first),
            at(to.end),
            N,
            at(to.traction[0]),
            at(to.traction[1]),
            at(to.traction[2]),
            tangent.as_ptr(),
            to.regimes.wrapping_add(first),
            &mut counts,
            message.as_mut_ptr().cast(),
            message.len(),
        )
    };
    assert_eq!(status, CL_SUCCESS, "{:?}", CStr::from_bytes_until_nul(&message));
    counts
}

/// 300 points are three chunks of the interface.
#[test]
fn the_interface_gives_what_the_law_gives() {
    let (input, law, mut out) = (input(), c_law(), Output::new());
    // SAFETY: blocks of `N` points that no one else knows.
    out.counts = unsafe { call(&law, 0..N, &input.jump, input.begin.as_ptr(), &Targets::new(&mut out)) };
    assert!(out.counts.stick > 20 && out.counts.slip > 20 && out.counts.open > 20);
    assert_eq!(out, by_rust(&input));
}

#[test]
fn the_state_may_be_updated_in_place() {
    let (input, law, mut out) = (input(), c_law(), Output::new());
    out.end.copy_from_slice(&input.begin);
    let targets = Targets::new(&mut out);
    // SAFETY: as above, with begin = end.
    let counts = unsafe { call(&law, 0..N, &input.jump, targets.end, &targets) };
    out.counts = counts;
    assert_eq!(out, by_rust(&input));
}

/// Parts of one block, whose components lie interleaved in memory.
#[test]
fn threads_share_a_law_and_a_block() {
    let (input, law, mut out) = (input(), c_law(), Output::new());
    out.end.copy_from_slice(&input.begin);
    let targets = Targets::new(&mut out);
    let parts = [0..1, 1..7, 7..150, 150..299, 299..N];
    let counts: Vec<Counts> = std::thread::scope(|scope| {
        let threads = parts.map(|part| {
            let (law, targets, jump) = (&law, &targets, &input.jump);
            // SAFETY: the parts are disjoint.
            scope.spawn(move || unsafe { call(law, part, jump, targets.end, targets) })
        });
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    out.counts = Counts {
        stick: counts.iter().map(|c| c.stick).sum(),
        slip: counts.iter().map(|c| c.slip).sum(),
        open: counts.iter().map(|c| c.open).sum(),
        invalid: 0,
    };
    assert_eq!(out, by_rust(&input));
}

/// Sets of bins with an index, with yield, in more chunks than one.
#[test]
fn resolved_laws_give_what_the_law_gives() {
    let n_sets = 3;
    let sets: Vec<u32> = (0..N as u32).map(|i| i / 7 % 3).collect();
    let (gaps, densities) = ([0.0, 1e-7, 2e-7, 1e-6, 2e-6, 3e-6], [1e5, 2e5, 3e5, 4e5, 5e5, 0.0]);
    let yielding = Yield {
        strength: 330e6,
        tangent_modulus: 620e6,
        curves: YieldCurves::Continuous,
    };
    let input = input();
    for (strength, n_radii, cone, limit) in [
        (0.0, 0, Cone::Box, AsperityLimit::Coulomb),
        (330e6, 0, Cone::Circle, AsperityLimit::ShearStrength),
        (330e6, 4, Cone::Circle, AsperityLimit::Coulomb),
        (330e6, 4, Cone::Box, AsperityLimit::Ceb),
    ] {
        let asperity = Asperity::try_new(
            ElasticPair::new(192e9, 0.3),
            1.4e-3,
            (strength > 0.0).then_some(yielding),
        )
        .unwrap();
        let of = |set: usize| {
            let bins = [0, 1].map(|bin| bin * n_sets + set);
            let (gaps, densities) = (bins.map(|i| gaps[i]), bins.map(|i| densities[i]));
            AsperityBins::try_new(asperity, gaps.to_vec(), densities.to_vec()).unwrap()
        };
        let friction = match n_radii {
            0 => AsperityFriction::StickSlip(HistoryRule::EndPoint),
            n => AsperityFriction::Annuli(HistoryRule::EndPoint, n),
        };
        let bins = PointParameters::try_indexed((0..n_sets).map(of).collect(), sets.clone()).unwrap();
        let by_rust = ResolvedLaw::try_new(bins, PointParameters::uniform(MU, N), friction, cone).unwrap();
        let by_rust = by_rust.with_limit(limit).unwrap();
        let mut message = [0_u8; 200];
        // SAFETY: all arrays have the documented lengths.
        let law = Handle(unsafe {
            cl_resolved_law(
                N,
                gaps.as_ptr(),
                densities.as_ptr(),
                2,
                n_sets,
                sets.as_ptr(),
                1.4e-3,
                192e9,
                0.3,
                strength,
                620e6,
                YieldCurves::Continuous.number(),
                &MU,
                1,
                HistoryRule::EndPoint.number(),
                cone.number(),
                limit.number(),
                n_radii,
                message.as_mut_ptr().cast(),
                message.len(),
            )
        });
        assert!(!law.0.is_null(), "{:?}", CStr::from_bytes_until_nul(&message));
        let n_state = by_rust.info().n_state();
        // SAFETY: from the constructor.
        assert_eq!(unsafe { cl_law_n_state(law.0) }, n_state);
        let mut states = [(); 2].map(|()| vec![0.0; n_state * N]);
        for jump in [&input.jump, &[2, 0, 1].map(|q| input.jump[q].clone())] {
            let mut outs = [Output::new(), Output::new()];
            outs.iter_mut().for_each(|out| out.end = vec![0.0; n_state * N]);
            let [ours, theirs] = &mut outs;
            // SAFETY: blocks of `N` points that no one else knows.
            ours.counts = unsafe { call(&law, 0..N, jump, states[0].as_ptr(), &Targets::new(ours)) };
            let [tx, ty, tn] = &mut theirs.traction;
            let mut regimes = vec![Regime::Open; N];
            let counts = by_rust.evaluate(
                0..N,
                Sticking::Coulomb,
                Components::new(&jump[0], &jump[1], &jump[2]),
                StateView::new(&states[1], N, 0),
                StateViewMut::new(&mut theirs.end, N, 0),
                ComponentsMut::new(tx, ty, tn),
                Some(TangentMut::from_entries(
                    theirs.tangent.each_mut().map(Vec::as_mut_slice),
                )),
                Some(&mut regimes),
            );
            theirs.counts = counts.into();
            theirs.regimes.clone_from(&ours.regimes);
            assert_eq!(ours, theirs);
            assert!(ours.counts.open > 20 && ours.counts.stick + ours.counts.slip > 20);
            states = outs.map(|out| out.end);
        }
    }
}

/// A law with a defect.
struct Panicking(LawInfo);

impl TractionLaw for Panicking {
    fn info(&self) -> &LawInfo {
        &self.0
    }

    fn len(&self) -> usize {
        N
    }

    fn evaluate(
        &self,
        _: Range<usize>,
        _: Sticking,
        _: Components<'_>,
        _: StateView<'_>,
        _: StateViewMut<'_>,
        _: ComponentsMut<'_>,
        _: Option<TangentMut<'_>>,
        _: Option<&mut [Regime]>,
    ) -> RegimeCounts {
        panic!("index 7 out of bounds")
    }

    fn derivative(
        &self,
        _: Range<usize>,
        _: Sticking,
        _: Components<'_>,
        _: StateView<'_>,
        _: Components<'_>,
        _: StateView<'_>,
        _: StateViewMut<'_>,
        _: StateViewMut<'_>,
        _: ComponentsMut<'_>,
        _: ComponentsMut<'_>,
    ) -> RegimeCounts {
        panic!("index 7 out of bounds")
    }
}

#[test]
fn a_panic_does_not_leave_the_interface() {
    let law = Law::try_new(Panicking(rust_law().info().clone())).unwrap();
    let (mut output, mut message) = ([0.0; 3 + 5], [0_u8; 200]);
    let zeros = [0.0; 5];
    let x = output.as_mut_ptr();
    let [y, n, end] = [1, 2, 3].map(|i| x.wrapping_add(i));
    // SAFETY: one point, with five state components.
    let status = unsafe {
        cl_law_evaluate(
            &law,
            0,
            1,
            Sticking::Coulomb.number(),
            zeros.as_ptr(),
            zeros.as_ptr(),
            zeros.as_ptr(),
            zeros.as_ptr(),
            end,
            1,
            x,
            y,
            n,
            ptr::null(),
            ptr::null_mut(),
            ptr::null_mut(),
            message.as_mut_ptr().cast(),
            message.len(),
        )
    };
    let text = CStr::from_bytes_until_nul(&message).unwrap().to_str().unwrap();
    assert_eq!(status, CL_ERROR);
    assert!(text.contains("defect") && text.contains("index 7"), "{text}");
}

/// The arrays of a call of [`cl_law_evaluate`]: name, entries, bytes per entry, whether it is written.
const ARRAYS: [(&str, usize, usize, bool); 20] = {
    const COUNT: usize = 4;
    const fn numbers(name: &'static str, written: bool) -> (&'static str, usize, usize, bool) {
        (name, COUNT, 8, written)
    }
    [
        numbers("jump_x", false),
        numbers("jump_y", false),
        numbers("jump_n", false),
        ("begin", 5 * COUNT, 8, false),
        ("tangent", 9, 8, false),
        ("end", 5 * COUNT, 8, true),
        numbers("traction_x", true),
        numbers("traction_y", true),
        numbers("traction_n", true),
        numbers("tangent[0] (xx)", true),
        numbers("tangent[1] (xy)", true),
        numbers("tangent[2] (xn)", true),
        numbers("tangent[3] (yx)", true),
        numbers("tangent[4] (yy)", true),
        numbers("tangent[5] (yn)", true),
        numbers("tangent[6] (nx)", true),
        numbers("tangent[7] (ny)", true),
        numbers("tangent[8] (nn)", true),
        ("regimes", COUNT, 4, true),
        ("counts", 1, size_of::<Counts>(), true),
    ]
};
const MESSAGE: usize = ARRAYS.len();
const MESSAGE_BYTES: usize = 160;

fn extent(array: usize) -> usize {
    ARRAYS.get(array).map_or(MESSAGE_BYTES, |(_, n, bytes, _)| n * bytes)
}

/// A call with every array, the message too, at an offset in bytes in one block of memory; stride of the states in points.
/// Returns the status, the memory before the call and the memory after it.
fn call_in(offsets: &[usize; MESSAGE + 1], stride: usize) -> (i32, Vec<u8>, Vec<u8>) {
    let mu = 0.3;
    // SAFETY: one set of parameters, one friction coefficient, no message.
    let law = Handle(unsafe {
        cl_elastic_dry_friction_law(
            4,
            &1e12,
            &1e12,
            &1e12,
            1,
            &mu,
            1,
            HistoryRule::Incremental.number(),
            ptr::null_mut(),
            0,
        )
    });
    let mut memory = vec![0.0_f64; 1024];
    let start = memory.as_mut_ptr().cast::<u8>();
    let at = |array: usize| start.wrapping_add(offsets[array]);
    let numbers = |array: usize| at(array).cast::<f64>();
    for (entry, array) in (9..18).enumerate() {
        // SAFETY: the offsets are multiples of eight within the memory.
        unsafe { at(4).cast::<*mut f64>().add(entry).write(numbers(array)) };
    }
    // SAFETY: numbers are bytes.
    let copy = || unsafe { std::slice::from_raw_parts(start.cast_const(), 8 * 1024) }.to_vec();
    let before = copy();
    // SAFETY: all arrays are within the memory, of the documented lengths.
    let status = unsafe {
        cl_law_evaluate(
            law.0,
            0,
            4,
            Sticking::Coulomb.number(),
            numbers(0),
            numbers(1),
            numbers(2),
            numbers(3),
            numbers(5),
            stride,
            numbers(6),
            numbers(7),
            numbers(8),
            at(4).cast::<*mut f64>(),
            at(18).cast::<i32>(),
            at(19).cast::<Counts>(),
            at(MESSAGE).cast(),
            MESSAGE_BYTES,
        )
    };
    (status, before, copy())
}

fn apart() -> [usize; MESSAGE + 1] {
    std::array::from_fn(|array| 256 * array)
}

#[test]
fn every_overlap_of_two_arrays_is_refused_before_anything_is_written() {
    assert_eq!(call_in(&apart(), 4).0, CL_SUCCESS);
    let name = |array: usize| ARRAYS.get(array).map_or("message", |row| row.0);
    let written = |array: usize| ARRAYS.get(array).is_none_or(|row| row.3);
    let mut pairs = 0;
    for (i, j) in (0..=MESSAGE).flat_map(|j| (0..j).map(move |i| (i, j))) {
        let (first, second) = (extent(i), extent(j));
        // Both begin together, and each begins in the last eight bytes of the other.
        let places = [(0, 0), (0, (first - 1) / 8 * 8), ((second - 1) / 8 * 8, 0)];
        for (a, b) in places {
            let mut offsets = apart();
            // Two slots behind all others, so that long arrays do not reach into a third one.
            (offsets[i], offsets[j]) = (6000 + a, 6000 + b);
            let (status, before, after) = call_in(&offsets, 4);
            let place = format!("{} at {a}, {} at {b}", name(i), name(j));
            let same_states = (name(i), name(j)) == ("begin", "end") && a == b;
            if !(written(i) || written(j)) || same_states {
                assert_eq!(status, CL_SUCCESS, "{place}");
                continue;
            }
            pairs += 1;
            assert_eq!(status, CL_ERROR, "{place}");
            if j == MESSAGE {
                assert_eq!(
                    before, after,
                    "{place}: nothing may be written where the message is another array"
                );
            } else {
                let text = after[offsets[MESSAGE]..].to_vec();
                let text = CStr::from_bytes_until_nul(&text).unwrap().to_str().unwrap();
                let named = text.contains(name(i)) && text.contains(name(j)) && text.contains("overlap");
                assert!(named, "{place}: {text}");
                let mut untouched = after.clone();
                let message = offsets[MESSAGE]..offsets[MESSAGE] + MESSAGE_BYTES;
                untouched[message.clone()].copy_from_slice(&before[message]);
                assert_eq!(before, untouched, "{place}");
            }
        }
    }
    assert!(pairs > 500, "{pairs}");
}

#[test]
fn arrays_that_only_lie_between_one_another_are_not_refused() {
    let separate = call_in(&apart(), 4);
    // Components of `begin` and of `end` in turn, and the tractions between those of a third block.
    let mut offsets = apart();
    (offsets[3], offsets[5]) = (6000, 6000 + 4 * 8);
    (offsets[6], offsets[7]) = (6000 + 8 * 8, 6000 + 8 * 8 + 12 * 8);
    let (status, ..) = call_in(&offsets, 12);
    assert_eq!((separate.0, status), (CL_SUCCESS, CL_SUCCESS));
}

#[test]
fn a_message_over_parameters_is_not_written() {
    let mut parameters = [1e12, 1e12, 1e12, -1.0];
    let before = parameters;
    let start = parameters.as_mut_ptr();
    // SAFETY: one number each, and a message of eight bytes.
    let law = unsafe {
        cl_elastic_dry_friction_law(
            1,
            start,
            start.wrapping_add(1),
            start.wrapping_add(2),
            1,
            start.wrapping_add(3),
            1,
            HistoryRule::Incremental.number(),
            start.wrapping_add(3).cast(),
            8,
        )
    };
    assert!(law.is_null());
    assert_eq!(parameters, before);
}
