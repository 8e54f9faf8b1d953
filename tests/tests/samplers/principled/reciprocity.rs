//! Reciprocity: light goes both ways alike.

use glam::Vec3;
use raggio_tests::{Pcg, for_each_device};

use super::{Closure, WHITE, closures};

fn upward(random: &mut Pcg) -> Vec3 {
    let w = random.direction().as_vec3();
    w.with_z(w.z.abs().max(0.02)).normalize()
}

/// Closure as the light sees it that comes back: for transmitted light, from the other side.
fn reversed(closure: &Closure, below: bool) -> Closure {
    if !below || closure.thin_walled {
        return *closure;
    }
    Closure { eta: 1.0 / closure.eta, outside: !closure.outside, ..*closure }
}

/// Closures of the base, and of coat and sheen over nothing: what these keep from each other is by the direction seen
/// alone.
fn reciprocal() -> Vec<(&'static str, Closure)> {
    let nothing = Closure { base_color: Vec3::ZERO, specular: 0.0, ..WHITE };
    let mut all: Vec<_> = closures()
        .into_iter()
        .map(|(what, closure)| (what, Closure { clearcoat: 0.0, sheen_color: Vec3::ZERO, ..closure }))
        .collect();
    all.push(("coat alone", Closure { clearcoat: 0.8, clearcoat_roughness: 0.5, ..nothing }));
    all.push(("sheen alone", Closure { sheen_color: Vec3::ONE, sheen_roughness: 0.7, ..nothing }));
    all
}

/// Values are f(wo, wi) = f(wi, wo), each over the squared index on its own side.
#[test]
fn bases_are_reciprocal() {
    for_each_device(|device| {
        for (what, closure) in reciprocal() {
            // Diffuse light enters a body as it leaves it, whatever the indices.
            let closure = if closure.thin_walled { closure } else { Closure { diffuse_transmission: 0.0, ..closure } };
            let mut random = Pcg::new(5);
            let mut nonzero = 0;
            for below in [false, true] {
                let flip = |w: Vec3| if below { w.with_z(-w.z) } else { w };
                let pairs: Vec<_> = (0..10_000).map(|_| (upward(&mut random), flip(upward(&mut random)))).collect();
                let back: Vec<_> = pairs.iter().map(|(wo, wi)| (flip(*wi), flip(*wo))).collect();
                let scale = if below && !closure.thin_walled { closure.eta.powi(-2) } else { 1.0 };
                let there = closure.eval(&device, &pairs);
                for (((wo, wi), there), back) in
                    pairs.iter().zip(there).zip(reversed(&closure, below).eval(&device, &back))
                {
                    let (there, back) = (scale * there.0 / wi.z.abs(), back.0 / wo.z);
                    // Near the critical angle what is transmitted hangs on a difference.
                    let m = if below { closure.eta * *wo + *wi } else { *wo + *wi }.normalize();
                    let least = wo.dot(m).abs().min(wi.dot(m).abs());
                    let allowed = if below { 3e-3 + 2e-6 / (least * least) } else { 3e-3 };
                    let near = (there - back).abs().max_element() <= allowed * there.max(back).max_element().max(1e-3);
                    assert!(near, "{}: {what} from {wo} to {wi}: {there}, but back {back}", device.label);
                    nonzero += u32::from(there != Vec3::ZERO);
                }
            }
            assert!(nonzero > 5000, "{}: {what} scatters nothing", device.label);
        }
    });
}
