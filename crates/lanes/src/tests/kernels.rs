//! Kernels of the tests: one for each few instructions, and some whose control flow or memory is intricate.

use std::fmt::Write as _;

use super::assembly::{Given, Source, WORDS, store};

/// Instructions on scalars: type of the result, and of all operands.
const SCALAR: &[(&str, &str, &str, Given)] = &[
    ("float", "float", "FAdd FSub FMul FDiv", Given::Floats),
    ("uint", "uint", "IAdd ISub IMul BitwiseAnd BitwiseOr BitwiseXor UDiv UMod", Given::Words),
    ("int", "int", "SDiv SRem", Given::Words),
    ("uint", "shift", "ShiftLeftLogical ShiftRightLogical ShiftRightArithmetic", Given::Words),
    ("bool", "float", "FOrdEqual FUnordNotEqual FOrdLessThan FOrdGreaterThan", Given::Floats),
    ("bool", "float", "FOrdLessThanEqual FOrdGreaterThanEqual FOrdNotEqual FUnordEqual", Given::Floats),
    ("bool", "float", "FUnordLessThan FUnordGreaterThan FUnordLessThanEqual FUnordGreaterThanEqual", Given::Floats),
    ("bool", "uint", "IEqual INotEqual ULessThan UGreaterThan ULessThanEqual UGreaterThanEqual", Given::Words),
    ("bool", "uint", "SLessThan SGreaterThan SLessThanEqual SGreaterThanEqual", Given::Words),
    ("bool", "bool", "LogicalAnd LogicalOr LogicalEqual LogicalNotEqual", Given::Words),
    ("float", "float1", "FNegate", Given::Floats),
    ("uint", "uint1", "SNegate Not BitReverse BitCount", Given::Words),
    ("bool", "bool1", "LogicalNot", Given::Words),
    ("bool", "float1", "IsNan IsInf", Given::Floats),
    ("float", "uint1", "ConvertUToF ConvertSToF", Given::Words),
    ("uint", "float1", "ConvertFToU", Given::Moderate),
    ("int", "float1", "ConvertFToS", Given::Moderate),
];

/// Functions of GLSL.std.450 on scalars.
const FUNCTIONS: &[(&str, &str, usize, Given)] = &[
    ("float", "FMin FMax", 2, Given::Floats),
    ("uint", "UMin UMax SMin SMax", 2, Given::Words),
    ("float", "FAbs Sqrt Floor Ceil Trunc RoundEven Fract", 1, Given::Floats),
    ("float", "FClamp FMix", 3, Given::Floats),
];

/// Kernels for each instruction that computes.
pub fn instructions(source: &mut Source) {
    for (i, (result, operands, names, given)) in SCALAR.iter().enumerate() {
        let mut body = String::new();
        for (word, name) in names.split(' ').enumerate() {
            // Other operands for each, some of them constant.
            let (a, b) = (word % 4, word % 4 + 4);
            let arguments = match *operands {
                "float" => format!("%@f{a} %@f{b}"),
                "bool" => format!("%@b{a} %@b{b}"),
                "float1" => format!("%@f{a}"),
                "bool1" => format!("%@b{a}"),
                "uint1" => format!("%@u{a}"),
                "shift" => {
                    let _ = writeln!(body, "%@s{word} = OpBitwiseAnd %uint %@u{b} %c31");
                    format!("%@u{a} %@s{word}")
                }
                _ if name.ends_with("Div") || name.ends_with("Mod") || name.ends_with("Rem") => {
                    let _ = writeln!(body, "%@s{word} = OpBitwiseOr %uint %@u{b} %c1");
                    format!("%@u{a} %@s{word}")
                }
                _ => format!("%@u{a} %@u{b}"),
            };
            let kind = if name.starts_with("ConvertF") { "uint" } else { result };
            let kind = if *name == *"ConvertFToS" { "int" } else { kind };
            let _ = writeln!(body, "%@r{word} = Op{name} %{kind} {arguments}");
            body += &store(word, &format!("%@r{word}"), kind);
        }
        source.kernel(&format!("op{i}"), *given, &body);
    }
    for (i, (kind, names, count, given)) in FUNCTIONS.iter().enumerate() {
        let mut body = String::new();
        for (word, name) in names.split(' ').enumerate() {
            let letter = if *kind == "float" { 'f' } else { 'u' };
            let arguments: Vec<_> = (0..*count).map(|k| format!("%@{letter}{}", (word + 3 * k) % WORDS)).collect();
            let _ = writeln!(body, "%@r{word} = OpExtInst %{kind} %glsl {name} {}", arguments.join(" "));
            body += &store(word, &format!("%@r{word}"), kind);
        }
        source.kernel(&format!("glsl{i}"), *given, &body);
    }
    vectors(source);
}

/// Instructions on vectors and matrices.
fn vectors(source: &mut Source) {
    let three =
        "%@x = OpCompositeConstruct %v3float %@f0 %@f1 %@f2\n%@y = OpCompositeConstruct %v3float %@f3 %@f4 %@f5\n";
    let components = |value: &str, first: usize, count: usize| {
        let mut text = String::new();
        for k in 0..count {
            let _ = writeln!(text, "%@part{} = OpCompositeExtract %float {value} {k}", first + k);
            text += &store(first + k, &format!("%@part{}", first + k), "float");
        }
        text
    };
    for (name, instruction) in [
        ("cross", "OpExtInst %v3float %glsl Cross %@x %@y"),
        ("reflect", "OpExtInst %v3float %glsl Reflect %@x %@y"),
        ("normalize", "OpExtInst %v3float %glsl Normalize %@x"),
        ("scaled", "OpVectorTimesScalar %v3float %@x %@f7"),
        ("shuffle", "OpVectorShuffle %v3float %@x %@y 5 0 1"),
        ("insert", "OpCompositeInsert %v3float %@f6 %@x 1"),
    ] {
        let body = format!("{three}%@r = {instruction}\n{}", components("%@r", 0, 3));
        source.kernel(name, Given::Floats, &body);
    }
    let body = format!(
        "{three}%@m = OpCompositeConstruct %m32 %@x %@y\n%@v = OpCompositeConstruct %v2float %@f6 %@f7\n\
         %@p = OpMatrixTimesVector %v3float %@m %@v\n%@q = OpVectorTimesMatrix %v2float %@x %@m\n\
         %@d = OpDot %float %@x %@y\n%@l = OpExtInst %float %glsl Length %@x\n{}{}{}{}",
        components("%@p", 0, 3),
        components("%@q", 3, 2),
        store(5, "%@d", "float"),
        store(6, "%@l", "float")
    );
    source.kernel("matrix", Given::Floats, &body);
    let body = format!(
        "%@v = OpCompositeConstruct %v4uint %@u0 %@u1 %@u2 %@u3\n%@k = OpBitwiseAnd %uint %@u4 %c3\n\
         %@e = OpVectorExtractDynamic %uint %@v %@k\n%@both = OpCompositeConstruct %v2bool %@b0 %@b1\n\
         %@all = OpAll %bool %@both\n%@any = OpAny %bool %@both\n%@p = OpVectorShuffle %v2uint %@v %@v 2 0\n\
         %@q = OpVectorShuffle %v2uint %@v %@v 1 3\n%@s = OpSelect %v2uint %@both %@p %@q\n\
         %@s0 = OpCompositeExtract %uint %@s 0\n%@s1 = OpCompositeExtract %uint %@s 1\n\
         %@t = OpSelect %uint %@b5 %@u5 %@u6\n%@w = OpSelect %uint %isOn %@u5 %@u6\n{}{}{}{}{}{}{}",
        store(0, "%@e", "uint"),
        store(1, "%@all", "bool"),
        store(2, "%@any", "bool"),
        store(3, "%@s0", "uint"),
        store(4, "%@s1", "uint"),
        store(5, "%@t", "uint"),
        store(6, "%@w", "uint"),
    );
    source.kernel("choices", Given::Words, &body);
}

/// Kernels that read and write memory in all ways.
pub fn memory(source: &mut Source) {
    // Elements of a buffer that each invocation chooses, and one for all; whole, in part, by an index within.
    let mut body = String::from(
        "%@k = OpBitwiseAnd %uint %@u0 %c15\n%@n = OpBitwiseAnd %uint %@u1 %c7\n\
         %@p = OpAccessChain %toItem %items_ %c0 %@k\n%@all = OpLoad %item %@p\n\
         %@a = OpCompositeExtract %uint %@all 0\n%@y = OpCompositeExtract %float %@all 1 1\n\
         %@m = OpCompositeExtract %float %@all 2 1 0\n%@w = OpCompositeExtract %uint %@all 3 7\n\
         %@pv = OpAccessChain %toVector %items_ %c0 %c9 %c1\n%@v = OpLoad %v3float %@pv\n\
         %@v2 = OpCompositeExtract %float %@v 2\n%@pw = OpAccessChain %toWord %items_ %c0 %@k %c3 %@n\n\
         %@own = OpLoad %uint %@pw\n%@pu = OpAccessChain %toWord %items_ %c0 %c5 %c3 %@n\n%@one = OpLoad %uint %@pu\n\
         %@n1 = OpBitwiseAnd %uint %@n %c1\n%@pm = OpAccessChain %toFloat %items_ %c0 %@k %c2 %@n1 %c2\n\
         %@e = OpLoad %float %@pm\n",
    );
    for (word, (value, kind)) in [
        ("%@a", "uint"),
        ("%@y", "float"),
        ("%@m", "float"),
        ("%@w", "uint"),
        ("%@v2", "float"),
        ("%@own", "uint"),
        ("%@one", "uint"),
        ("%@e", "float"),
    ]
    .into_iter()
    .enumerate()
    {
        body += &store(word, value, kind);
    }
    source.kernel("gathers", Given::Words, &body);

    // The invocation's own element: whole words, in a branch, at an index that is the same for all or not.
    source.kernel(
        "columns",
        Given::Words,
        &("%@p0 = OpAccessChain %toWord %states %c0 %@i %c0\n%@s0 = OpLoad %uint %@p0\n\
           %@x0 = OpIAdd %uint %@s0 %@u0\nOpStore %@p0 %@x0\n%@p1 = OpAccessChain %toPair %states %c0 %@i %c1\n\
           %@s1 = OpLoad %v2float %@p1\n%@s10 = OpCompositeExtract %float %@s1 1\n%@k = OpBitwiseAnd %uint %@u1 %c7\n\
           OpSelectionMerge %@end None\nOpBranchConditional %@b2 %@yes %@end\n%@yes = OpLabel\n\
           %@x1 = OpCompositeConstruct %v2float %@f3 %@f4\nOpStore %@p1 %@x1\n\
           %@p2 = OpAccessChain %toWord %states %c0 %@i %c2 %@k\n%@s2 = OpLoad %uint %@p2\nOpStore %@p2 %@u5\n\
           %@p3 = OpAccessChain %toWord %states %c0 %@i %c2 %@s2\nOpBranch %@end\n%@end = OpLabel\n\
           %@p4 = OpAccessChain %toWord %states %c0 %@i %c2 %c3\n%@s4 = OpLoad %uint %@p4\nOpStore %@p4 %c9\n"
            .to_owned()
            + &store(0, "%@s0", "uint")
            + &store(1, "%@s10", "float")
            + &store(2, "%@s4", "uint")),
    );

    // An array within a structure, copied whole, and written and read at indices that differ.
    let body = "%@a = OpVariable %localPair Function\n%@b = OpVariable %localPair Function\n%%%\n\
                %@k = OpBitwiseAnd %uint %@u0 %c7\n%@n = OpBitwiseAnd %uint %@u1 %c7\n\
                %@nothing = OpCompositeConstruct %words %c1 %c2 %c3 %c4 %c5 %c6 %c7 %c8\n\
                %@pair = OpCompositeConstruct %pair %@u2 %@nothing\nOpStore %@a %@pair\n\
                %@p0 = OpAccessChain %local %@a %c1 %@k\nOpStore %@p0 %@u3\n\
                OpSelectionMerge %@end None\nOpBranchConditional %@b4 %@yes %@end\n%@yes = OpLabel\n\
                %@p1 = OpAccessChain %local %@a %c1 %c2\nOpStore %@p1 %@u4\n\
                %@p2 = OpAccessChain %local %@a %c1 %@n\nOpStore %@p2 %@u5\nOpBranch %@end\n%@end = OpLabel\n\
                %@copy = OpLoad %pair %@a\nOpStore %@b %@copy\n%@p3 = OpAccessChain %local %@b %c1 %@n\n\
                %@r0 = OpLoad %uint %@p3\n%@p4 = OpAccessChain %local %@b %c1 %c2\n%@r1 = OpLoad %uint %@p4\n\
                %@p5 = OpAccessChain %local %@b %c0\n%@r2 = OpLoad %uint %@p5\n";
    let stores = (0..3).map(|k| store(k, &format!("%@r{k}"), "uint")).collect::<String>();
    source.kernel("arrays", Given::Words, &format!("{body}{stores}"));
}
