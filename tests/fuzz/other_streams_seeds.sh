#!/usr/bin/env bash
# First inputs for other_streams_fuzz: small videos with sound, subtitles, chapters, tags, covers and
# attachments, made by the program ffmpeg; none without it.
#
#   other_streams_seeds.sh DIR
set -euo pipefail
mkdir -p "$1"
command -v ffmpeg >/dev/null || exit 0
work=$(mktemp -d)
trap 'rm -rf -- "$work"' EXIT
printf '1\n00:00:00,100 --> 00:00:00,400\nHello\n\n2\n00:00:00,500 --> 00:00:00,900\n<i>you</i>\n' \
    >"$work/text.srt"
printf 'WEBVTT\n\n00:00.100 --> 00:00.900 line:0\nHello\n' >"$work/text.vtt"
cat >"$work/text.ass" <<'TEXT'
[Script Info]
ScriptType: v4.00+
[V4+ Styles]
Format: Name, Fontname, Fontsize
Style: Default,Arial,16
[Events]
Format: Layer, Start, End, Style, Name, MarginL, MarginR, MarginV, Effect, Text
Dialogue: 0,0:00:00.20,0:00:00.80,Default,,0,0,0,,{\b1}Hello\Nyou
TEXT
cat >"$work/tags.txt" <<'TEXT'
;FFMETADATA1
title=A film
encoder=somebody
[CHAPTER]
TIMEBASE=1/1000
START=0
END=400
title=One
[CHAPTER]
TIMEBASE=1/1000
START=400
END=1000
TEXT
echo 'no font' >"$work/font.ttf"

count=0
# seed NAME TEXT ARGUMENT...: a clip of 5 pictures with such sound and this text, in several ways
seed() {
    local name=$1 file=$work/$1 text=$work/$2
    shift 2
    ffmpeg -nostdin -v error -y -f lavfi -i testsrc=size=16x16:rate=5:duration=1 \
        -f lavfi -i sine=duration=1.1:sample_rate=8000 -i "$work/tags.txt" -i "$text" "$@" -map_metadata 2 \
        -fflags +bitexact "$file" || return 0 # not every FFmpeg has every encoder
    count=$((count + 1))
    for way in '\0\0' '\1\0' '\2\0' '\20\0' '\21\0' '\15\0' '\14\1' '\34\2' '\0\17'; do
        { printf "$way" && cat "$file"; } >"$seeds/seed$count-${way//[!0-9]/_}-${name%.*}"
    done
}
seeds=$1
small=(-map 0:v -c:v mpeg4 -g 2)
seed a.mkv text.srt "${small[@]}" -map 1:a -map 3 -c:a pcm_s16le -c:s srt \
    -metadata:s:a language=eng -metadata:s:s language=deu
seed b.mkv text.ass "${small[@]}" -map 1:a -map 3 -c:a flac -c:s ass \
    -attach "$work/font.ttf" -metadata:s:t mimetype=font/ttf
seed c.mkv text.vtt "${small[@]}" -map 3 -c:s webvtt
seed d.mkv text.srt "${small[@]}" -map 1:a -map 1:a -c:a:0 libvorbis -c:a:1 aac
seed e.mp4 text.srt "${small[@]}" -map 1:a -map 3 -c:a aac -c:s mov_text
seed f.mov text.srt "${small[@]}" -map 1:a -c:a pcm_s16be -timecode 01:00:00:00
seed g.avi text.srt "${small[@]}" -map 1:a -c:a mp3
seed h.ts text.srt -map 0:v -c:v mpeg2video -r 25 -map 1:a -c:a mp2
seed i.ogg text.srt -map 0:v -c:v libtheora -map 1:a -ar 48000 -c:a libopus
seed j.nut text.srt "${small[@]}" -map 1:a -c:a adpcm_ima_wav
seed k.flv text.srt -map 0:v -c:v flv -map 1:a -ar 11025 -c:a mp3
seed l.mp4 text.srt "${small[@]}" -map 0:v -c:v:1 png -disposition:v:1 attached_pic \
    -map 1:a -c:a ac3 -b:a 32k
