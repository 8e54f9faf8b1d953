//! Hints for keys that a table does not have: what other programs' names for things are called here.

use crate::fault::Step;
use crate::file::PrincipledFile;
use crate::names;
use crate::schema;

/// Names that are tried, in lower case and without underscores, and what is right: a key of the same table or a sentence.
type Foreign = &'static [(&'static [&'static str], &'static str)];

const TOP: Foreign = &[
    (&["light"], "lights"),
    (&["group", "collections", "instances", "assemblies"], "groups"),
    (&["lamps", "emitters", "arealights"], "a lamp is a shape whose material has an `emission_strength`"),
    (
        &["sun", "pointlights", "spotlights"],
        "lights are tables of a list, as in `[[lights]]` and `directional = { direction = [0, -1, 0] }`",
    ),
    (&["sky", "background", "world", "envmap"], "environment"),
    (&["fog", "haze", "mist", "medium", "atmosphere", "volume"], "air"),
    (&["objects", "object", "geometry", "meshes", "models", "primitives"], "shapes"),
    (&["film", "settings", "image", "output", "sampler", "integrator"], "render"),
];

const RENDER: Foreign = &[
    (&["spp", "samplesperpixel", "samplecount"], "samples"),
    (&["depth", "bounces", "maxbounces", "maxpathlength"], "max_depth"),
    (&["resolution", "size", "dimensions"], "the size is `width` and `height`"),
    (&["transparent", "transparentbackground", "filmtransparent", "rgba", "coverage"], "alpha"),
    (&["reconstructionfilter", "rfilter", "pixelfilter"], "filter"),
    (
        &[
            "integrator",
            "tonemapper",
            "tonemap",
            "exposure",
            "denoise",
            "device",
            "threads",
            "timelimit",
            "noise",
            "aov",
        ],
        "that is an option of `raggio render`, not a key of the scene",
    ),
];

const MEDIUM: Foreign = &[
    (&["sigmaa", "absorptioncoefficient"], "absorption"),
    (&["sigmas", "scatteringcoefficient", "scatter"], "scattering"),
    (&["g", "asymmetry", "phase", "phasefunction", "meancosine"], "anisotropy"),
    (
        &["density", "extinction", "sigmat", "attenuation", "albedo", "color", "meanfreepath", "radius"],
        "a medium is what it loses per unit of length: `absorption` and `scattering`",
    ),
];

const CAMERA: Foreign = &[
    (&["from", "eye", "origin", "lookfrom", "location", "translation", "center"], "position"),
    (&["to", "at", "target", "lookto"], "look_at"),
    (&["vup", "upvector", "worldup"], "up"),
    (&["fovy", "yfov", "fieldofview", "angle"], "vertical_fov_degrees"),
    (
        &["hfov", "fovx", "xfov", "horizontalfov", "horizontalfovdegrees"],
        "the angle is that between the picture's top and bottom edges, `vertical_fov_degrees`",
    ),
    (&["k", "cameramatrix", "intrinsicmatrix", "calibration", "principalpoint", "fx", "fy", "cx", "cy"], "intrinsics"),
    (&["orthographic", "orthoscale", "orthographicscale", "ymag"], "orthographic_height"),
    (&["panoramic", "equirectangular", "latlong", "spherical", "envmap"], "panorama"),
    (
        &["projection", "type", "kind", "model", "cameramodel"],
        "one of `vertical_fov_degrees`, `intrinsics`, `orthographic_height` and `panorama` says what kind of camera it is",
    ),
    (&["lensradius", "fstop", "fnumber", "bokeh"], "aperture_radius"),
    (&["focaldistance", "focallength", "focus"], "focus_distance"),
    (&["aspect", "aspectratio"], "the aspect is that of `width` and `height` in [render]"),
    (&["animation", "path", "keys", "motion"], "keyframes"),
];

const KEYFRAME: Foreign = &[
    (&["t", "seconds", "moment", "at"], "time"),
    (&["frame"], "a keyframe's `time` is in seconds: that of frame F is (F - 1) / fps"),
    (&["from", "eye", "origin", "lookfrom", "location", "translation"], "position"),
    (&["to", "target", "lookto"], "look_at"),
    (&["fov", "fovy", "yfov", "fieldofview", "angle"], "vertical_fov_degrees"),
    (&["focaldistance", "focus"], "focus_distance"),
    (&["upvector", "vup", "viewup"], "up"),
    (&["orthographic", "orthoscale", "orthographicscale", "ymag"], "orthographic_height"),
];

const INTRINSICS: Foreign = &[
    (&["fx", "fy", "f", "focallength", "fl"], "focal"),
    (&["cx", "cy", "principal", "center", "pp"], "principal_point"),
    (&["width", "height", "w", "h", "resolution"], "size"),
    (&["s"], "skew"),
];

const ENVIRONMENT: Foreign = &[
    (&["file", "filename", "path", "map", "hdri", "hdr", "texture", "envmap"], "image"),
    (&["strength", "brightness", "scale", "multiplier", "power"], "intensity"),
    (&["radiance", "constant"], "color"),
    (&["top", "sky", "up"], "zenith"),
    (&["bottom", "ground", "down"], "horizon"),
];

const MATERIAL: Foreign = &[
    (&["ior", "eta", "n", "indexofrefraction", "refractionindex"], "refractive_index"),
    (&["albedo", "basecolor", "diffuse", "diffusecolor", "reflectance", "kd"], "color"),
    (
        &["emission", "emissive", "emit", "light", "radiance"],
        "the light given off is `emission_color` times `emission_strength`",
    ),
    (&["emissivecolor", "lightcolor"], "emission_color"),
    (&["emissivestrength", "emissiveintensity", "intensity", "power", "brightness"], "emission_strength"),
    (&["mirror", "shininess", "gloss", "glossiness", "reflectivity"], "smoothness"),
    (&["roughness"], "`smoothness` is its opposite, 1 for a mirror; or write `principled = { roughness = ... }`"),
    (
        &["transmission", "transparency", "transparent", "glass"],
        "glass has a `refractive_index`; or write `principled = { transmission = ... }`",
    ),
    (
        &["type", "kind", "bsdf", "shader"],
        "a material's keys say what it is, such as `smoothness` or `refractive_index`",
    ),
    (&["interior", "volume", "fog", "subsurface", "scattering", "absorption", "inside"], "medium"),
];

const PRINCIPLED: Foreign = &[
    (&["color", "albedo", "diffuse", "diffusecolor"], "base_color"),
    (&["metalness", "metal"], "metallic"),
    (&["refractiveindex", "indexofrefraction", "eta"], "ior"),
    (&["emission", "emissioncolor", "emissivecolor", "emit"], "emissive"),
    (&["emissionstrength", "emissiveintensity", "emissionintensity"], "emissive_strength"),
    (&["smoothness", "gloss", "glossiness"], "`roughness` is its opposite, 0 for a mirror"),
    (&["opacity"], "alpha"),
    (&["transparency", "transmissionfactor"], "transmission"),
    (
        &["texture", "map", "colortexture", "colormap", "basecolormap", "albedotexture", "albedomap", "diffusetexture"],
        "base_color_texture",
    ),
    (&["normaltexture", "normals", "bump", "bumpmap"], "normal_map"),
    (&["roughnesstexture", "metallictexture", "roughnessmap", "metallicmap"], "metallic_roughness_texture"),
    (&["emissivemap", "emissiontexture"], "emissive_texture"),
    (&["coat"], "clearcoat"),
    (&["sheen"], "sheen_color"),
];

const TEXTURE: Foreign = &[
    (&["file", "filename", "path", "texture", "uri"], "image"),
    (&["uv", "texcoord", "uvchannel"], "uv_set"),
    (&["translation", "position"], "offset"),
    (&["repeat", "tiling", "tile"], "scale"),
    (&["sampler", "interpolation"], "filter"),
];

const SHAPE: Foreign = &[
    (&["cube", "cuboid", "aabb", "block"], "box"),
    (&["quad", "rect", "square", "parallelogram"], "rectangle"),
    (&["file", "model", "gltf", "glb", "obj", "ply", "stl", "trianglemesh", "instance"], "mesh"),
    (&["ground", "floor", "halfspace"], "plane"),
    (&["collection", "object", "name"], "group"),
    (&["translation", "translate", "rotation", "rotationdegrees", "rotate", "scale", "matrix"], "transform"),
    (&["ball"], "sphere"),
    (&["circle", "disc"], "disk"),
    (&["tube", "pipe", "rod"], "cylinder"),
    (
        &["type", "kind", "geometry", "center", "radius", "position", "normal", "size", "corner", "point"],
        "a shape's geometry is a table of its own, as in `sphere = { center = [0, 1, 0], radius = 1 }`",
    ),
];

const LIGHT: Foreign = &[
    (&["sun", "distant", "distantlight", "directionallight", "parallel", "infinite"], "directional"),
    (&["pointlight", "omni", "bulb"], "point"),
    (&["spotlight", "cone"], "spot"),
    (
        &["area", "arealight", "sphere", "rectangle", "disk", "mesh"],
        "a lamp with a surface is a shape whose material has an `emission_strength`",
    ),
    (
        &["type", "kind", "position", "direction", "color", "intensity", "power"],
        "a light's kind is a table of its own, as in `point = { position = [0, 2, 0], intensity = 5 }`",
    ),
];

const POINT: Foreign = &[
    (&["origin", "location", "from", "center", "translation"], "position"),
    (&["strength", "power", "brightness", "energy", "lumens", "candela"], "intensity"),
    (&["emissioncolor", "rgb"], "color"),
    (&["radius", "size"], "a light with a size is a `sphere` whose material has an `emission_strength`"),
    (&["range", "falloff", "attenuation"], "light goes on for ever, and falls with the square of the distance"),
];

const SPOT: Foreign = &[
    (&["origin", "location", "from", "center", "translation"], "position"),
    (&["axis", "forward", "normal"], "direction"),
    (&["to", "target", "lookat", "at"], "`direction` is the way from `position` to the target"),
    (&["innerangle", "innerconeangle", "inner"], "inner_degrees"),
    (&["outerangle", "outerconeangle", "outer", "angle", "coneangle"], "outer_degrees"),
    (&["strength", "power", "brightness", "energy", "lumens", "candela"], "intensity"),
    (&["emissioncolor", "rgb"], "color"),
    (&["range", "falloff", "attenuation"], "light goes on for ever, and falls with the square of the distance"),
];

const DIRECTIONAL: Foreign = &[
    (&["axis", "forward", "normal"], "direction"),
    (
        &["position", "origin", "location", "from"],
        "it is infinitely far away: `direction` is that in which the light shines",
    ),
    (&["to", "target", "lookat", "at"], "`direction` is that in which the light shines"),
    (&["angle", "size", "angulardiameter", "diameter", "softness"], "angle_degrees"),
    (&["strength", "power", "brightness", "energy", "irradiance", "lux", "illuminance"], "intensity"),
    (&["emissioncolor", "rgb"], "color"),
];

const TRANSFORM: Foreign = &[
    (&["position", "translate", "offset", "location", "center"], "translation"),
    (&["rotate", "rotation", "euler", "angles"], "rotation_degrees"),
    (&["size", "factor"], "scale"),
    (&["matrix", "toworld"], "a transform is a `translation`, `rotation_degrees` and a `scale`"),
];

const SPHERE: Foreign = &[
    (&["position", "origin", "location", "translation", "point"], "center"),
    (&["r", "size"], "radius"),
    (&["diameter"], "`radius` is half of it"),
];

const PLANE: Foreign = &[(&["position", "origin", "center"], "point"), (&["n", "up", "direction"], "normal")];

const RECTANGLE: Foreign = &[
    (&["position", "origin", "point"], "corner"),
    (&["u", "edge1", "edgea"], "edge_u"),
    (&["v", "edge2", "edgeb"], "edge_v"),
    (
        &["center", "size", "width", "height", "normal"],
        "a rectangle is a `corner` and two edges, `edge_u` and `edge_v`",
    ),
];

const BOX: Foreign = &[
    (&["position", "origin", "location", "translation"], "center"),
    (&["scale", "extent", "extents", "dimensions"], "size"),
    (&["min", "max", "corner"], "a box is its `center` and its `size`"),
];

const DISK: Foreign = &[
    (&["position", "origin", "location", "translation", "point"], "center"),
    (&["n", "up", "direction", "axis"], "normal"),
    (&["r", "size"], "radius"),
    (&["diameter"], "`radius` is half of it"),
];

const CYLINDER: Foreign = &[
    (&["start", "p0", "from", "bottom", "position", "origin"], "base"),
    (&["end", "p1", "to"], "top"),
    (&["r", "size"], "radius"),
    (&["diameter"], "`radius` is half of it"),
    (&["caps", "closed", "solid", "cap"], "capped"),
    (&["center", "axis", "height", "length"], "`base` and `top` are the centres of its ends"),
];

const CONE: Foreign = &[
    (&["start", "p0", "from", "bottom", "position", "origin"], "base"),
    (&["end", "p1", "to", "apex", "tip"], "top"),
    (&["r", "size", "baseradius", "radius0", "bottomradius"], "radius"),
    (&["radius1", "tipradius"], "top_radius"),
    (&["diameter"], "`radius` is half of it"),
    (&["caps", "closed", "solid", "cap"], "capped"),
    (&["center", "axis", "height", "length"], "`base` and `top` are the centres of its ends"),
];

const MESH: Foreign = &[
    (&["path", "filename", "model", "uri", "src"], "file"),
    (&["position", "translate", "offset", "location", "center"], "translation"),
    (&["size"], "scale"),
];

/// Hint that follows "unknown key": what is right in its place, or all keys that there are.
pub(crate) fn hint(path: &[Step], key: &str, known: &[&str]) -> String {
    match right_for(foreign_to(path), key) {
        Some(sentence) if sentence.contains(' ') => return sentence.to_string(),
        Some(right) => return format!("did you mean {}?", names::quoted(right)),
        None => {}
    }
    match principled_key(key).filter(|_| is_plain_material(path)) {
        Some(inside) => format!("that is a key of `principled`: write `principled = {{ {inside} = ... }}`"),
        None => names::hint(key, known),
    }
}

/// Key of the same table that is meant by an unknown one.
pub(crate) fn meant(path: &[Step], key: &str, known: &'static [&'static str]) -> Option<&'static str> {
    right_for(foreign_to(path), key)
        .or_else(|| names::nearest(key, known.iter().copied()))
        .filter(|key| !key.contains(' '))
}

fn foreign_to(path: &[Step]) -> Foreign {
    let keys: Vec<&str> = path.iter().map(|step| if let Step::Key(key) = step { key.as_str() } else { "" }).collect();
    match keys.as_slice() {
        [] => TOP,
        ["render"] => RENDER,
        ["camera"] => CAMERA,
        ["camera", "intrinsics"] => INTRINSICS,
        ["camera", "keyframes", _] => KEYFRAME,
        ["environment"] => ENVIRONMENT,
        ["air"] | ["materials", _, "medium"] => MEDIUM,
        ["materials", _] => MATERIAL,
        ["materials", _, "principled"] => PRINCIPLED,
        ["materials", _, "principled", _] => TEXTURE,
        ["lights", _] => LIGHT,
        ["lights", _, "point"] => POINT,
        ["lights", _, "spot"] => SPOT,
        ["lights", _, "directional"] => DIRECTIONAL,
        ["shapes", _] => SHAPE,
        ["shapes", _, "transform"] | ["groups", _, _, "transform"] => TRANSFORM,
        ["groups", _, _] => SHAPE,
        ["groups", _, _, key] => foreign_to(&[Step::from("shapes"), Step::from(0), Step::from(*key)]),
        ["shapes", _, "sphere"] => SPHERE,
        ["shapes", _, "plane"] => PLANE,
        ["shapes", _, "rectangle"] => RECTANGLE,
        ["shapes", _, "disk"] => DISK,
        ["shapes", _, "cylinder"] => CYLINDER,
        ["shapes", _, "cone"] => CONE,
        ["shapes", _, "box"] => BOX,
        ["shapes", _, "mesh"] => MESH,
        _ => &[],
    }
}

fn is_plain_material(path: &[Step]) -> bool {
    matches!(path, [Step::Key(materials), _] if materials == "materials")
}

fn right_for(table: Foreign, key: &str) -> Option<&'static str> {
    let key = simplified(key);
    table.iter().find(|(foreign, _)| foreign.contains(&key.as_str())).map(|(_, right)| *right)
}

/// Key of a principled material that is meant, whatever its spelling.
fn principled_key(key: &str) -> Option<String> {
    let keys = schema::keys::<PrincipledFile>();
    let same = keys.iter().find(|known| simplified(known) == simplified(key));
    same.cloned().or_else(|| right_for(PRINCIPLED, key).filter(|right| !right.contains(' ')).map(str::to_string))
}

fn simplified(key: &str) -> String {
    key.chars().filter(|character| !matches!(character, '_' | '-')).flat_map(char::to_lowercase).collect()
}

#[cfg(test)]
mod tests {
    use schemars::JsonSchema;

    use super::*;
    use crate::file::{
        BoxFile, CameraFile, ConeFile, CylinderFile, DirectionalFile, DiskFile, EnvironmentFile, IntrinsicsFile,
        LightFile, MaterialFile, MediumFile, MeshFile, PlaneFile, PointFile, RectangleFile, RenderFile, SceneFile,
        ShapeFile, SphereFile, SpotFile, TextureTable, TransformFile,
    };

    /// Asserts that the table leads from keys that do not exist to keys that do.
    fn check<T: JsonSchema>(table: Foreign) {
        let keys = schema::keys::<T>();
        let mut names: Vec<&str> = table.iter().flat_map(|(foreign, _)| *foreign).copied().collect();
        names.sort_unstable();
        assert!(names.windows(2).all(|pair| pair[0] != pair[1]), "a name stands twice: {names:?}");
        for (foreign, right) in table {
            assert!(right.contains(' ') || keys.iter().any(|key| key == right), "{right}");
            for key in *foreign {
                assert_eq!(*key, simplified(key));
                assert!(!keys.iter().any(|known| known == key), "{key}");
            }
        }
    }

    #[test]
    fn every_hint_leads_somewhere() {
        check::<SceneFile>(TOP);
        check::<RenderFile>(RENDER);
        check::<CameraFile>(CAMERA);
        check::<IntrinsicsFile>(INTRINSICS);
        check::<EnvironmentFile>(ENVIRONMENT);
        check::<MediumFile>(MEDIUM);
        check::<MaterialFile>(MATERIAL);
        check::<PrincipledFile>(PRINCIPLED);
        check::<TextureTable>(TEXTURE);
        check::<LightFile>(LIGHT);
        check::<PointFile>(POINT);
        check::<SpotFile>(SPOT);
        check::<DirectionalFile>(DIRECTIONAL);
        check::<ShapeFile>(SHAPE);
        check::<TransformFile>(TRANSFORM);
        check::<SphereFile>(SPHERE);
        check::<PlaneFile>(PLANE);
        check::<RectangleFile>(RECTANGLE);
        check::<DiskFile>(DISK);
        check::<CylinderFile>(CYLINDER);
        check::<ConeFile>(CONE);
        check::<BoxFile>(BOX);
        check::<MeshFile>(MESH);
    }
}
