# Completion for chevalctl, chevald and cheval-bake. Subcommands, options and values are those that their --help lists; it takes
# about ten milliseconds. The names of outfits come from the running mirror, where there is one.

# Lines of --help that follow the heading $2, up to the next one. $1: the help.
_cheval_section() {
    sed -n "/^$2:/,/^[^ ]/p" <<<"$1" | grep '^  [^ ]'
}

# The values that an option takes by its line in --help: "{a,b}"; "FILE" and "DIR" say that it is a path.
_cheval_values() {
    local line
    line=$(_cheval_section "$1" Options | grep -E -- "^  ([^ ]*,)?$2(,| )")
    [[ $line =~ \{([^}]*)\} ]] && tr ',' ' ' <<<"${BASH_REMATCH[1]}"
}

# Where the mirror is, by what stands on the line already.
_cheval_outfits() {
    local bus=system i
    for ((i = 1; i < COMP_CWORD; i++)); do
        [[ ${COMP_WORDS[i]} == --bus ]] && bus=${COMP_WORDS[i + 1]}
    done
    timeout 1 "$1" outfit list --bus "$bus" 2>/dev/null
}

_cheval() {
    local program=$1 current=$2 previous=$3 help word names
    local -a path=()
    COMPREPLY=()
    help=$("$program" --help 2>/dev/null) || return 0
    # Follows the subcommands that stand on the line: each has a help of its own.
    local i
    for ((i = 1; i < COMP_CWORD; i++)); do
        word=${COMP_WORDS[i]}
        names=$(_cheval_section "$help" Subcommands | awk '{print $1}')
        if grep -qxF -- "$word" <<<"$names"; then
            path+=("$word")
            help=$("$program" "${path[@]}" --help 2>/dev/null) || return 0
        fi
    done

    local takes
    if [[ $previous == -* ]]; then
        takes=$(_cheval_section "$help" Options | grep -E -- "^  ([^ ]*,)?$previous(,| )")
        # A word in capitals after the option's names: it takes a value.
        if [[ $takes =~ ^\ \ [^\ ]+\ (TEXT|INT|UINT|FLOAT|FILE|DIR|PATH) ]]; then
            names=$(_cheval_values "$help" "$previous")
            [[ $previous == --outfit ]] && names=$(_cheval_outfits "$program")
            if [[ -n $names ]]; then
                mapfile -t COMPREPLY < <(compgen -W "$names" -- "$current")
            else
                mapfile -t COMPREPLY < <(compgen -f -- "$current")
            fi
            return 0
        fi
    fi
    if [[ $current == -* ]]; then
        names=$(_cheval_section "$help" Options | grep -oE -- '^  -[^ ]*' | tr ',' ' ')
    else
        names=$(_cheval_section "$help" Subcommands | awk '{print $1}')
        [[ ${path[*]} == "outfit set" ]] && names=$(_cheval_outfits "$program")
        if [[ -z $names ]]; then
            # Positional arguments are files and folders; without any there are only options left.
            if [[ -n $(_cheval_section "$help" Positionals) ]]; then
                mapfile -t COMPREPLY < <(compgen -f -- "$current")
                return 0
            fi
            names=$(_cheval_section "$help" Options | grep -oE -- '^  -[^ ]*' | tr ',' ' ')
        fi
    fi
    mapfile -t COMPREPLY < <(compgen -W "$names" -- "$current")
}

complete -o filenames -F _cheval chevalctl chevald cheval-bake
