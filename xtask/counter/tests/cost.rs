//! The costs of instructions whose code and cycles stand in the makers' manuals.

#[path = "../src/cost.rs"]
mod cost;

use cost::{Cost, Model};

/// Loads, stores, cycles without and with a taken branch.
type Costs = (u64, u64, u64, u64);

/// Costs of an instruction after one that does not access memory.
fn cost(model: Model, code: &[u16]) -> Costs {
    after(model, code, &Cost::default())
}

fn after(model: Model, code: &[u16], before: &Cost) -> Costs {
    let bytes: Vec<u8> = code.iter().flat_map(|half| half.to_le_bytes()).collect();
    let Cost { loads, stores, cycles, branch, .. } = model.cost(&bytes, before);
    (loads, stores, cycles, cycles + branch)
}

#[test]
fn models_have_names() {
    for (name, model) in [("m0plus", Model::M0Plus), ("m4", Model::M4), ("ibex", Model::Ibex)] {
        assert_eq!(Model::named(name), Some(model));
    }
    assert_eq!(Model::named("z80"), None);
}

#[test]
fn thumb_costs_are_those_of_the_manuals() {
    // code, on the M0+, on the M4
    type Row<'a> = (&'a str, &'a [u16], Costs, Costs);
    let rows: [Row; 16] = [
        ("adds r0, r1, r2", &[0x1888], (0, 0, 1, 1), (0, 0, 1, 1)),
        ("ldr r0, [r1]", &[0x6808], (1, 0, 2, 2), (1, 0, 2, 2)),
        ("str r0, [r1]", &[0x6008], (0, 1, 2, 2), (0, 1, 1, 1)),
        ("ldrb r0, [r1, r2]", &[0x5c88], (1, 0, 2, 2), (1, 0, 2, 2)),
        ("push {r4, lr}", &[0xb510], (0, 2, 3, 3), (0, 2, 3, 3)),
        ("pop {r4, pc}", &[0xbd10], (2, 0, 3, 5), (2, 0, 3, 5)),
        ("ldm r0!, {r1-r4}", &[0xc81e], (4, 0, 5, 5), (4, 0, 5, 5)),
        ("b .", &[0xe7fe], (0, 0, 1, 2), (0, 0, 1, 3)),
        ("beq .", &[0xd0fe], (0, 0, 1, 2), (0, 0, 1, 3)),
        ("bx lr", &[0x4770], (0, 0, 1, 2), (0, 0, 1, 3)),
        ("bl", &[0xf000, 0xf800], (0, 0, 2, 3), (0, 0, 1, 3)),
        ("muls r0, r1", &[0x4348], (0, 0, 1, 1), (0, 0, 1, 1)),
        ("ldrd r0, r1, [r2]", &[0xe9d2, 0x0100], (2, 0, 3, 3), (2, 0, 3, 3)),
        ("vdiv.f32 s0, s1, s2", &[0xee80, 0x0a81], (0, 0, 14, 14), (0, 0, 14, 14)),
        ("vsqrt.f32 s0, s1", &[0xeeb1, 0x0ae0], (0, 0, 14, 14), (0, 0, 14, 14)),
        ("vmul.f32 s0, s1, s2", &[0xee20, 0x0a81], (0, 0, 1, 1), (0, 0, 1, 1)),
    ];
    for (name, code, m0, m4) in rows {
        assert_eq!(cost(Model::M0Plus, code), m0, "{name} on the M0+");
        assert_eq!(cost(Model::M4, code), m4, "{name} on the M4");
    }
}

#[test]
fn a_load_after_a_load_waits_on_the_m0_only() {
    let load: &[u16] = &[0x6808];
    let before = Model::M4.cost(&[0x08, 0x68], &Cost::default());
    assert_eq!(after(Model::M4, load, &before), (1, 0, 1, 1));
    assert_eq!(after(Model::M0Plus, load, &before), (1, 0, 2, 2));
}

#[test]
fn riscv_costs_are_those_of_the_manual() {
    let rows: [(&str, &[u16], Costs); 9] = [
        ("add a0, a1, a2", &[0x8533, 0x00c5], (0, 0, 1, 1)),
        ("lw a0, 0(a1)", &[0xa503, 0x0005], (1, 0, 2, 2)),
        ("sw a0, 0(a1)", &[0xa023, 0x00a5], (0, 1, 2, 2)),
        ("beq a0, a1, .", &[0x0063, 0x00b5], (0, 0, 1, 3)),
        ("jal ra, .", &[0x00ef, 0x0000], (0, 0, 1, 2)),
        ("mul a0, a1, a2", &[0x8533, 0x02c5], (0, 0, 3, 3)),
        ("div a0, a1, a2", &[0xc533, 0x02c5], (0, 0, 37, 37)),
        ("c.lw a0, 0(a1)", &[0x4188], (1, 0, 2, 2)),
        ("c.jr ra", &[0x8082], (0, 0, 1, 2)),
    ];
    for (name, code, expected) in rows {
        assert_eq!(cost(Model::Ibex, code), expected, "{name}");
    }
}

#[test]
fn stores_on_the_stack_are_told_from_others() {
    let on_stack = |model: Model, bytes: &[u8]| model.cost(bytes, &Cost::default()).is_on_stack;
    assert!(on_stack(Model::M4, &0x9001u16.to_le_bytes()), "str r0, [sp, #4]");
    assert!(on_stack(Model::M4, &0xb500u16.to_le_bytes()), "push {{lr}}");
    assert!(!on_stack(Model::M4, &0x6008u16.to_le_bytes()), "str r0, [r1]");
    assert!(on_stack(Model::Ibex, &0x0011_2023u32.to_le_bytes()), "sw ra, 0(sp)");
    assert!(!on_stack(Model::Ibex, &0x00a5_a023u32.to_le_bytes()), "sw a0, 0(a1)");
}
