# What a program of the tests can do; what it does stands below. KIND is its role or protocol, `n` the number of its answers.
echo "$TRACKFAIL_SEED $TRACKFAIL_RUN $EXTRA $TRAX" > environment
n=0

# What comes before the first answer.
begin() {
    case $KIND in
        trax) echo @@TRAX:hello ;;
        signal | detector) ask ;;
    esac
}

# Reads a message and writes it down; fails when there is none.
ask() {
    read -r line && printf '%s\n' "$line" >> log && case $line in quit | @@TRAX:quit*) false ;; esac
}

# Path of the message's image.
image() {
    printf '%s' "$line" | sed -n 's|^[^/]*\(/[^"[:cntrl:]]*png\).*|\1|p'
}

# Says an answer.
say() {
    case $KIND in
        lines) echo "$n,2.5,3,4 0.25" ;;
        trax) echo "@@TRAX:state $n,2.5,3,4 confidence=0.$n other=7" ;;
        signal) echo "{\"score\": $n.5}" ;;
        detector) echo "{\"score\": $n.5, \"label\": $((n % 2))}" ;;
    esac
}

# Answers the first message by these words.
first() {
    begin
    ask
    echo "$1"
}

# Answers until there are so many answers, or to the end, and keeps the images.
answer() {
    while [ "$n" != "$1" ] && ask; do
        path=$(image)
        [ -z "$path" ] || cp "$path" "seen$n.png"
        say
        n=$((n + 1))
    done
}

# Starts a process that stays.
fork() {
    sleep 1000 &
    echo $! > grandchild
    echo $$ > child
}
