//! What a shell and `man` read of this command: in, the command line as data; out, completions and a manual page. They hold no dates and
//! no paths, so the same version always prints the same.

use clap_complete::generate;
use clap_mangen::Man;
use clap_mangen::roff::{Roff, bold, roman};
use graphstipple_core::Format;
use graphstipple_core::stages::nearest;

use crate::command::{COMPLETIONS, EXAMPLES, SHELLS, command, with_words};
use crate::error::{Error, Result};

/// The script with which a shell of this name completes the command.
///
/// # Errors
/// [`Error::Usage`] for another shell.
pub(crate) fn completions(shell: &str) -> Result<String> {
    let Some((_, generator)) = SHELLS.into_iter().find(|(name, _)| *name == shell) else {
        let names = SHELLS.map(|(name, _)| name);
        let [first, second, third] = names;
        let meant = nearest(shell, names).map_or_else(String::new, |name| format!("; did you mean {name}?"));
        return Err(Error::Usage(format!("--{COMPLETIONS} is {shell:?}, but it must be {first}, {second} or {third}{meant}")));
    };
    let mut script = Vec::new();
    generate(generator, &mut with_words(), "graphstipple", &mut script);
    Ok(in_text(script))
}

/// Exit codes, and what they say.
const EXIT_CODES: [(&str, &str); 4] = [
    ("0", "All is written."),
    ("1", "Something failed: a file cannot be read or written, or holds no image. Nothing is written."),
    ("2", "The arguments break a rule. Nothing is written."),
    ("130", "Interrupted. Nothing is written."),
];

/// The manual page, as troff source.
pub(crate) fn man() -> String {
    let page = Man::new(command(true));
    // The date stays empty.
    let mut source =
        concat!(".TH GRAPHSTIPPLE 1 \"\" \"graphstipple ", env!("CARGO_PKG_VERSION"), "\" \"User Commands\"\n").as_bytes().to_vec();
    let mut rest = Roff::new();
    rest.control("SH", ["EXAMPLES"]);
    rest.control("nf", []);
    rest.text(EXAMPLES.lines().skip(1).map(|line| roman(format!("{}\n", line.trim()))).collect::<Vec<_>>());
    rest.control("fi", []);
    rest.control("SH", ["FILES"]);
    rest.text([roman("The suffix of a file says its format.")]);
    for format in Format::ALL {
        rest.control("TP", []);
        rest.text([bold(format!(".{}", format.suffix))]);
        rest.text([roman(format!("{}: {}", format.name, format.holds))]);
    }
    rest.control("SH", ["EXIT STATUS"]);
    for (code, said) in EXIT_CODES {
        rest.control("TP", []);
        rest.text([bold(code)]);
        rest.text([roman(said)]);
    }
    let written = page
        .render_name_section(&mut source)
        .and_then(|()| page.render_synopsis_section(&mut source))
        .and_then(|()| page.render_options_section(&mut source))
        .and_then(|()| rest.to_writer(&mut source));
    written.expect("memory takes what is written to it");
    in_text(source)
}

/// What was written to memory.
fn in_text(bytes: Vec<u8>) -> String {
    String::from_utf8(bytes).expect("what is printed is made of text")
}

#[cfg(test)]
mod tests {
    use graphstipple_core::presets;

    use super::*;

    #[test]
    fn every_shell_has_every_flag_and_the_words() {
        for (shell, _) in SHELLS {
            let script = completions(shell).unwrap();
            let flags: Vec<String> = command(true).get_arguments().filter_map(|it| it.get_long().map(str::to_owned)).collect();
            assert!(flags.iter().all(|flag| script.contains(flag.as_str())), "{shell}");
            assert!(presets().iter().all(|preset| script.contains(preset.name)) && script.contains("layered"), "{shell}");
            assert_eq!(script, completions(shell).unwrap());
        }
        let told = |shell: &str| completions(shell).unwrap_err().to_string();
        assert_eq!(told("fihs"), "--completions is \"fihs\", but it must be bash, zsh or fish; did you mean fish?");
        assert_eq!(told("tcsh"), "--completions is \"tcsh\", but it must be bash, zsh or fish");
    }

    #[test]
    fn the_manual_page_has_all_options_formats_and_exit_codes() {
        let page = man();
        assert!(page.contains(".TH GRAPHSTIPPLE 1 \"\" \"graphstipple "), "{}", &page[..200]);
        for argument in command(true).get_arguments() {
            let flag = argument.get_long().map_or_else(|| "PHOTO".to_owned(), |flag| format!("\\-\\-{}", flag.replace('-', "\\-")));
            assert!(page.contains(&flag), "{flag}");
        }
        let sections: Vec<&str> = page.lines().filter_map(|line| line.strip_prefix(".SH ")).collect();
        assert_eq!((sections[0], sections[1]), ("NAME", "SYNOPSIS"));
        assert_eq!(sections[sections.len() - 3..], ["EXAMPLES", "FILES", "\"EXIT STATUS\""]);
        assert!(Format::ALL.iter().all(|format| page.contains(&format!("\\fB.{}\\fR", format.suffix))));
        assert!(EXIT_CODES.iter().all(|(code, _)| page.contains(&format!("\\fB{code}\\fR"))));
    }
}
