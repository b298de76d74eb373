fn main() {
    use pelage_texel::*;
    let which = std::env::args().nth(1).unwrap_or("long".into());
    let depth: u32 = std::env::args().nth(2).map_or(7, |d| d.parse().unwrap());
    let fur = match which.as_str() { "short" => Fur::short(), "plush" => Fur::plush(), _ => Fur::long() };
    let t = std::time::Instant::now();
    let g = fur.geometry();
    println!("{} triangles {:?}", g.triangles.len(), t.elapsed());
    let t = std::time::Instant::now();
    let texel = build("fur", &g, &BuildOptions { depth, ..BuildOptions::standard() }, &|_| ()).unwrap();
    println!("built {:?}, {} bytes", t.elapsed(), texel.memory());
    texel.validate().unwrap();
    for l in texel.levels() { println!("{} {} voxels {:.1} B/voxel", l.resolution(), l.len(), l.memory() as f64 / l.len() as f64); }
}
