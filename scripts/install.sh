#!/usr/bin/env bash
# Puts raggio, its completions and its manual pages below a prefix, or takes them away; `make install` calls it.
set -euo pipefail

if [ "${1:-}" = --remove ]; then
    prefix=$2
    rm -f "$prefix"/bin/raggio "$prefix"/share/man/man1/raggio{,-*}.1 \
        "$prefix"/share/bash-completion/completions/raggio \
        "$prefix"/share/zsh/site-functions/_raggio \
        "$prefix"/share/fish/vendor_completions.d/raggio.fish
    echo "removed raggio from $prefix"
    exit
fi

program=$1 prefix=$2
share=$prefix/share
mkdir -p "$prefix/bin" "$share"/{man/man1,bash-completion/completions,zsh/site-functions,fish/vendor_completions.d}
# Under another name first: a raggio that is running keeps its file.
cp "$program" "$prefix/bin/.raggio.new"
chmod 755 "$prefix/bin/.raggio.new"
mv -f "$prefix/bin/.raggio.new" "$prefix/bin/raggio"
"$program" manual "$share/man/man1"
"$program" completions bash >"$share/bash-completion/completions/raggio"
"$program" completions zsh >"$share/zsh/site-functions/_raggio"
"$program" completions fish >"$share/fish/vendor_completions.d/raggio.fish"
echo "installed $prefix/bin/raggio, its manual pages and its completions for bash, zsh and fish"
case ":$PATH:" in
*":$prefix/bin:"*) ;;
*) echo "$prefix/bin is not on your PATH: add it, in ~/.profile for instance, with  export PATH=\"$prefix/bin:\$PATH\"" ;;
esac
