# Completion for chevalctl and chevald. Subcommands, options and values are those that their --help lists, which takes about
# ten milliseconds a level. The names of outfits come from the running mirror, where there is one.

# _cheval_section HELP HEADING: the entries under that heading.
_cheval_section() {
    sed -n "/^$2:/,/^[^ ]/p" <<<"$1" | grep '^  [^ ]'
}

# Outfits of the mirror on the bus that the line names.
_cheval_outfits() {
    local bus=system i
    for ((i = 1; i < COMP_CWORD; i++)); do
        [[ ${COMP_WORDS[i]} == --bus ]] && bus=${COMP_WORDS[i + 1]}
    done
    timeout 1 "$1" outfit list --bus "$bus" 2>/dev/null
}

_cheval_files() {
    # Not a completion when a test calls it.
    compopt -o filenames 2>/dev/null
    mapfile -t COMPREPLY < <(compgen -f -- "$1")
}

_cheval() {
    local program=$1 current=$2 previous=$3 help options names entry word i
    local -a path=()
    COMPREPLY=()
    help=$("$program" --help 2>/dev/null) || return 0
    options=$(_cheval_section "$help" Options)
    # Follows the subcommands that stand on the line: each has a help of its own, and takes the options of those before it too.
    for ((i = 1; i < COMP_CWORD; i++)); do
        word=${COMP_WORDS[i]}
        names=$(_cheval_section "$help" Subcommands | awk '{print $1}')
        if [[ -n $names ]] && grep -qxF -- "$word" <<<"$names"; then
            path+=("$word")
            help=$("$program" "${path[@]}" --help 2>/dev/null) || return 0
            options+=$'\n'$(_cheval_section "$help" Options)
        fi
    done

    if [[ $previous == -* ]]; then
        entry=$(grep -E -- "^  ([^ ]*,)?$previous(,| |$)" <<<"$options" | head -n 1)
        # A type after the option's names: it takes a value, perhaps one of a few.
        if [[ $entry =~ ^\ \ [^\ ]+\ (TEXT|INT|UINT|FLOAT|FILE|DIR|PATH)(:\{([^}]*)\})? ]]; then
            names=${BASH_REMATCH[3]//,/ }
            [[ $previous == --outfit ]] && names=$(_cheval_outfits "$program")
            if [[ -n $names ]]; then
                mapfile -t COMPREPLY < <(compgen -W "$names" -- "$current")
            else
                _cheval_files "$current"
            fi
            return 0
        fi
    fi

    names=$(_cheval_section "$help" Subcommands | awk '{print $1}')
    if [[ $current != -* && -z $names ]]; then
        if [[ ${path[*]} == "outfit set" ]]; then
            names=$(_cheval_outfits "$program")
        elif [[ -n $(_cheval_section "$help" Positionals) ]]; then
            _cheval_files "$current"
            return 0
        fi
    fi
    if [[ $current == -* || (-z $names && ${path[*]} != "outfit set") ]]; then
        names=$(grep -oE -- '^  -[^ ]*' <<<"$options" | tr ',' ' ' | sort -u)
    fi
    mapfile -t COMPREPLY < <(compgen -W "$names" -- "$current")
}

complete -F _cheval chevalctl chevald
