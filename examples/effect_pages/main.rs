//! Writes the catalogue of effects of the book, a page and a picture for each effect:
//! `cargo run --release --example effect_pages`.

mod pages;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::path::Path::new("docs/book/src");
    std::fs::create_dir_all(folder.join("effects"))?;
    for (path, text) in pages::pages()? {
        std::fs::write(folder.join(path), text)?;
    }
    Ok(())
}
