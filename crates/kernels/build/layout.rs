//! Rust twins of the kernels' structures, enumerations and constants, from slangc's reflection and the Slang files.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use serde_json::Value;

use crate::cpp::variant_name;
use crate::declarations::{Declarations, Enumeration};

/// Writes `layout.rs` and `declarations.txt` into the folder `out`, from the kernels' declarations and the places of their
/// parameters in C++, in SPIR-V, and in SPIR-V that asks hardware, of storage buffers and of addresses.
pub fn generate(
    declarations: &Declarations,
    entry_points: &[String],
    cpp: &Places,
    spirv: &Places,
    queries: &[Places; 2],
    out: &Path,
) -> Result<(), String> {
    let mut types = Types::default();
    let mut text = String::new();
    for name in ["work", "film", "output", "input", "resting"] {
        types.collect(element(cpp.parameter(name)?))?;
    }
    let (scene_cpp, scene_spirv) = (cpp.scene("offset")?, spirv.scene("index")?);
    for (in_cpp, in_spirv) in scene_cpp.iter().zip(&scene_spirv) {
        if in_cpp.element != in_spirv.element {
            return Err(format!("`{}` is laid out differently in C++ and in SPIR-V", in_cpp.name));
        }
        types.collect(&in_cpp.element)?;
    }
    text += &types.text;
    text += &scene_buffers(&scene_cpp)?;
    text += &index_checks(&scene_cpp, declarations)?;
    text += &constants_of_places(cpp, spirv, &scene_cpp, &scene_spirv)?;
    text += &structure_bindings(queries, &scene_spirv)?;
    text += &enumerations_and_constants(declarations);
    text += &entry_point_names(entry_points);
    // Kernels that are compiled later are compared with these: `raggio_kernels::compile`.
    std::fs::write(out.join("declarations.txt"), declarations.text())
        .and_then(|()| std::fs::write(out.join("layout.rs"), text))
        .map_err(|e| format!("cannot write the layouts: {e}"))
}

/// Places of the kernels' parameters, as a target's reflection gives them.
pub struct Places {
    parameters: Vec<Value>,
}

impl Places {
    /// Reads the reflection in the file `path`.
    pub fn read(path: &Path) -> Result<Self, String> {
        let text = std::fs::read_to_string(path).map_err(|e| format!("cannot read slangc's reflection: {e}"))?;
        let json: Value = serde_json::from_str(&text).map_err(|e| format!("slangc's reflection is not JSON: {e}"))?;
        let parameters = json["parameters"].as_array().cloned().ok_or("slangc's reflection has no parameters")?;
        Ok(Self { parameters })
    }

    fn parameter(&self, name: &str) -> Result<&Value, String> {
        self.parameters.iter().find(|p| p["name"] == name).ok_or(format!("the kernels have no parameter `{name}`"))
    }

    /// The scene's lists, with their `offset` in C++ or their `index` among the bindings of SPIR-V.
    fn scene(&self, place: &str) -> Result<Vec<Buffer>, String> {
        buffers(self.parameter("scene")?, place)
    }

    /// Binding of the structure that hardware traces by, in the scene's descriptor set.
    fn structure(&self) -> Result<u64, String> {
        let fields = element(self.parameter("scene")?)["fields"].as_array();
        let field = fields.into_iter().flatten().find(|field| field["name"] == "structure");
        field.and_then(|field| field["binding"]["index"].as_u64()).ok_or("the scene has no structure".into())
    }

    /// Binding of the parameter `name` in SPIR-V, or the descriptor set of one that is a block.
    fn index(&self, name: &str) -> Result<u64, String> {
        self.parameter(name)?["binding"]["index"].as_u64().ok_or(format!("`{name}` has no index"))
    }

    /// Word of the C++ parameters at which the parameter `name` stands.
    pub fn word(&self, name: &str) -> Result<u64, String> {
        let offset = self.parameter(name)?["binding"]["offset"].as_u64();
        offset.map(|offset| offset / 8).ok_or(format!("`{name}` has no offset"))
    }

    /// Word of the C++ scene block at which the scene's list of this number stands.
    pub fn scene_word(&self, list: usize) -> Result<u64, String> {
        let lists = self.scene("offset")?;
        lists.get(list).map(|list| list.place / 8).ok_or("the scene has fewer lists in C++ than in SPIR-V".into())
    }

    /// Number of the scene's list at a place of SPIR-V, if it is one.
    pub fn scene_list(&self, set: u32, binding: u32) -> Option<usize> {
        let own = self.index("scene").ok()? == u64::from(set);
        let lists = self.scene("index").ok()?;
        lists.iter().position(|list| own && list.place == u64::from(binding))
    }

    /// Members of the elements of parameter `name` with the word at which each begins, and `size`, the number of words.
    pub fn words_of(&self, name: &str) -> Result<Vec<(String, u64)>, String> {
        let element = element(self.parameter(name)?);
        let fields = element["fields"].as_array().ok_or(format!("`{name}` has no members"))?;
        let (mut words, mut end) = (vec![], 0);
        for field in fields {
            let number = |key: &str| field["binding"][key].as_u64().ok_or(format!("a member of `{name}` has no {key}"));
            let offset = number("offset")?;
            end = offset + number("size")?;
            words.push((field["name"].as_str().unwrap_or_default().to_owned(), offset / 4));
        }
        words.push(("size".to_owned(), end / 4));
        Ok(words)
    }
}

/// Type of the elements that a buffer, constant buffer or parameter block holds.
fn element(parameter: &Value) -> &Value {
    let kind = &parameter["type"];
    if kind["resultType"].is_object() { &kind["resultType"] } else { &kind["elementType"] }
}

/// Structured buffer of the scene: its Rust name, where it is bound, what it holds.
struct Buffer {
    name: String,
    place: u64,
    element: Value,
}

/// Lists the structured buffers of a parameter block, those in nested structures too; `place` is their offset or index.
fn buffers(block: &Value, place: &str) -> Result<Vec<Buffer>, String> {
    fn walk(fields: &Value, base: u64, place: &str, found: &mut Vec<Buffer>) -> Result<(), String> {
        for field in fields.as_array().ok_or("a structure without fields")? {
            let name = snake(field["name"].as_str().unwrap_or_default());
            let at = base + field["binding"][place].as_u64().ok_or(format!("`{name}` has no place"))?;
            match field["type"]["kind"].as_str() {
                Some("struct") => walk(&field["type"]["fields"], at, place, found)?,
                Some("resource") if field["type"]["baseShape"] == "accelerationStructure" => {}
                Some("resource") => {
                    found.push(Buffer { name, place: at, element: field["type"]["resultType"].clone() })
                }
                other => return Err(format!("Scene holds buffers alone, and `{name}` is {other:?}")),
            }
        }
        Ok(())
    }
    let mut found = Vec::new();
    walk(&element(block)["fields"], 0, place, &mut found)?;
    Ok(found)
}

/// Structures by name, and their Rust text in order of dependence.
#[derive(Default)]
struct Types {
    seen: BTreeMap<String, ()>,
    text: String,
}

impl Types {
    /// Writes the structure `kind` and those it contains, once each.
    fn collect(&mut self, kind: &Value) -> Result<(), String> {
        if kind["kind"] == "array" {
            return self.collect(&kind["elementType"]);
        }
        if kind["kind"] != "struct" {
            return Ok(());
        }
        let name = kind["name"].as_str().ok_or("a structure without a name")?;
        if self.seen.insert(name.to_owned(), ()).is_some() {
            return Ok(());
        }
        let fields = kind["fields"].as_array().ok_or("a structure without fields")?;
        for field in fields {
            self.collect(&field["type"])?;
        }

        let size = kind["sizes"][0]["value"].as_u64().ok_or(format!("`{name}` has no size"))?;
        // Processors load lines of 64 bytes: what is as large as one or several should not lie across two.
        let repr = if size % 64 == 0 { "C, align(64)" } else { "C" };
        let mut text = format!(
            "/// `{name}` of the kernels.\n#[repr({repr})]\n#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]\npub struct {name} {{\n"
        );
        let mut checks = String::new();
        for field in fields {
            let member = snake(field["name"].as_str().unwrap_or_default());
            let _ = writeln!(text, "    pub {member}: {},", rust_type(&field["type"])?);
            let offset = &field["binding"]["offset"];
            let _ = writeln!(checks, "const _: () = assert!(std::mem::offset_of!({name}, {member}) == {offset});");
        }
        let _ = writeln!(checks, "const _: () = assert!(std::mem::size_of::<{name}>() == {size});\n");
        self.text += &text;
        self.text += "}\n";
        self.text += &checks;
        Ok(())
    }
}

fn rust_type(kind: &Value) -> Result<String, String> {
    Ok(match kind["kind"].as_str() {
        Some("scalar") => match kind["scalarType"].as_str() {
            Some("float32") => "f32".into(),
            Some("uint32") => "u32".into(),
            Some("int32") => "i32".into(),
            other => return Err(format!("the host has no twin of scalar {other:?}")),
        },
        Some("vector") => format!("[{}; {}]", rust_type(&kind["elementType"])?, kind["elementCount"]),
        Some("matrix") => {
            format!("[[{}; {}]; {}]", rust_type(&kind["elementType"])?, kind["columnCount"], kind["rowCount"])
        }
        Some("array") => format!("[{}; {}]", rust_type(&kind["elementType"])?, kind["elementCount"]),
        Some("struct") => kind["name"].as_str().unwrap_or_default().into(),
        other => return Err(format!("the host has no twin of {other:?}")),
    })
}

/// Writes the scene as the host fills it: one vector for each buffer.
fn scene_buffers(buffers: &[Buffer]) -> Result<String, String> {
    let mut text = String::from(
        "/// A scene as the kernels see it: a vector for each of their buffers. Scenes may share them.\n#[derive(Clone, Debug, Default, PartialEq)]\npub struct SceneBuffers {\n",
    );
    let mut slices = String::new();
    for Buffer { name, element, .. } in buffers {
        let _ = writeln!(text, "    pub {name}: Arc<Vec<{}>>,", rust_type(element)?);
        let _ = writeln!(
            slices,
            "            BufferBytes {{ name: \"{name}\", bytes: bytemuck::cast_slice(self.{name}.as_slice()), count: self.{name}.len(), stride: std::mem::size_of::<{}>() }},",
            rust_type(element)?
        );
    }
    let count = buffers.len();
    let _ = write!(
        text,
        "}}\n\nimpl SceneBuffers {{\n    /// The buffers in the order of [`SCENE_BINDINGS`].\n    pub fn bytes(&self) -> [BufferBytes<'_>; {count}] {{\n        [\n{slices}        ]\n    }}\n}}\n\n"
    );
    Ok(text)
}

/// Writes lookups for `SceneBuffers::check` that a new kind of shape must not be forgotten in.
fn index_checks(buffers: &[Buffer], declarations: &Declarations) -> Result<String, String> {
    let mut text = String::from(
        "impl SceneBuffers {\n    /// The largest material index that any element names.\n    pub(crate) fn largest_material(&self) -> Option<u32> {\n        let mut all = Vec::new();\n",
    );
    for Buffer { name, element, .. } in buffers {
        let fields = element["fields"].as_array();
        if fields.is_some_and(|fields| fields.iter().any(|field| field["name"] == "material")) {
            let _ = writeln!(text, "        all.extend(self.{name}.iter().map(|element| element.material).max());");
        }
    }
    text += "        all.into_iter().max()\n    }\n\n    /// How many shapes there are of a kind; none of an unknown kind.\n    pub(crate) fn shapes_of_kind(&self, kind: u32) -> usize {\n        match kind {\n";
    let kinds = declarations.enumerations.iter().find(|enumeration| enumeration.name == "ShapeKind");
    for kind in names(kinds.ok_or("the kernels have no `enum ShapeKind : uint`")?) {
        let buffer = buffers.iter().find(|buffer| buffer.element["name"] == kind);
        let name = &buffer.ok_or(format!("no buffer of the scene holds shapes of kind {kind}"))?.name;
        let _ = writeln!(text, "            k if k == ShapeKind::{kind} as u32 => self.{name}.len(),");
    }
    text += "            _ => 0,\n        }\n    }\n}\n\n";
    Ok(text)
}

/// Writes the place of each parameter: descriptor bindings for SPIR-V, offsets of 8 bytes for C++.
fn constants_of_places(
    cpp: &Places,
    spirv: &Places,
    scene_cpp: &[Buffer],
    scene_spirv: &[Buffer],
) -> Result<String, String> {
    let mut text = String::new();
    let mut constant = |doc: &str, name: &str, kind: &str, value: String| {
        let _ = writeln!(text, "/// {doc}\npub const {name}: {kind} = {value};");
    };
    let list = |buffers: &[Buffer], unit: u64| {
        format!("[{}]", buffers.iter().map(|b| (b.place / unit).to_string()).collect::<Vec<_>>().join(", "))
    };
    let count = scene_cpp.len();
    constant("Descriptor set of the scene.", "SCENE_SET", "u32", spirv.index("scene")?.to_string());
    constant(
        "Bindings of the scene's buffers in that set.",
        "SCENE_BINDINGS",
        &format!("[u32; {count}]"),
        list(scene_spirv, 1),
    );
    for name in ["film", "output", "input", "resting"] {
        constant(
            "Binding in descriptor set 0.",
            &format!("{}_BINDING", name.to_uppercase()),
            "u32",
            spirv.index(name)?.to_string(),
        );
    }
    constant(
        "Word of the C++ scene block at which each buffer's pointer and length stand.",
        "SCENE_WORDS",
        &format!("[usize; {count}]"),
        list(scene_cpp, 8),
    );
    for name in ["scene", "work", "film", "output", "input", "resting"] {
        constant(
            "Word of the C++ parameters at which it stands.",
            &format!("{}_WORD", name.to_uppercase()),
            "usize",
            cpp.word(name)?.to_string(),
        );
    }
    Ok(text)
}

/// Writes where the structure stands that hardware traces by; the lists around it are where they are without it.
fn structure_bindings([buffers_of, addresses]: &[Places; 2], lists: &[Buffer]) -> Result<String, String> {
    let known = buffers_of.scene("index")?;
    if !known.iter().map(|list| list.place).eq(lists.iter().map(|list| list.place)) {
        return Err("kernels that ask hardware have the scene's lists at other places".into());
    }
    let mut text = String::new();
    for (name, places) in [("STRUCTURE_BINDING", buffers_of), ("WIDE_STRUCTURE_BINDING", addresses)] {
        let binding = places.structure()?;
        let _ = writeln!(text, "/// Binding in the scene's descriptor set.\npub(crate) const {name}: u32 = {binding};");
    }
    Ok(text)
}

/// Writes Rust twins of the enumerations and constants, which the reflection leaves out.
fn enumerations_and_constants(declarations: &Declarations) -> String {
    let mut text = String::new();
    for enumeration in &declarations.enumerations {
        let Enumeration { name, variants } = enumeration;
        let _ = writeln!(
            text,
            "/// `{name}` of the kernels.\n#[repr(u32)]\n#[derive(Clone, Copy, Debug, PartialEq, Eq)]\npub enum {name} {{\n    {}\n}}",
            variants.join("\n    ")
        );
        let names: Vec<_> = names(enumeration).map(|variant| format!("Self::{variant}")).collect();
        let _ = writeln!(
            text,
            "impl {name} {{\n    /// All there are, in order.\n    pub const ALL: [Self; {}] = [{}];\n}}",
            names.len(),
            names.join(", ")
        );
    }
    for (name, value) in &declarations.constants {
        let _ = writeln!(text, "/// `{name}` of the kernels.\npub const {name}: u32 = {value};");
    }
    text
}

/// Writes `EntryPoint`, the list of the kernels.
fn entry_point_names(entry_points: &[String]) -> String {
    let each = |line: &dyn Fn(&str, &str) -> String| -> String {
        entry_points.iter().map(|entry| line(&variant_name(entry), entry)).collect()
    };
    let declared = each(&|variant, entry| format!("    /// `kernels/entry/{entry}.slang`.\n    {variant},\n"));
    let listed = each(&|variant, _| format!("Self::{variant}, "));
    let named = each(&|variant, entry| format!("            Self::{variant} => \"{entry}\",\n"));
    format!(
        "/// Kernels by the names of their entry points, the files of `kernels/entry`.\n\
         #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]\n\
         pub enum EntryPoint {{\n{declared}}}\n\n\
         impl EntryPoint {{\n\
         \x20   /// All kernels, in alphabetical order.\n\
         \x20   pub const ALL: [Self; {}] = [{listed}];\n\n\
         \x20   /// Name of the entry point, in the SPIR-V module too.\n\
         \x20   pub fn name(self) -> &'static str {{\n        match self {{\n{named}        }}\n    }}\n}}\n",
        entry_points.len()
    )
}

/// Names of an enumeration's variants.
fn names(enumeration: &Enumeration) -> impl Iterator<Item = &str> {
    enumeration.values().filter_map(|line| Some(line.split_once(" = ")?.0))
}

fn snake(name: &str) -> String {
    let mut out = String::new();
    for c in name.chars() {
        if c.is_uppercase() {
            out.push('_');
        }
        out.extend(c.to_lowercase());
    }
    out
}
