"""Trains the depth network. Usage: train.py --help

The learning rate is constant after a warm-up and falls to 0 over the last --decay batches. A run
stops at --batches and continues from its checkpoint, with other numbers where they are given.
"""
import argparse
import os
import random
import sys
import time

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--frames", default="frames", help="folder of the sets")
parser.add_argument("--sets", nargs="+", default=["train-*"])
parser.add_argument("--encoder", help="mobilenet_v2_1.0_224_quant.tflite, for a new run")
parser.add_argument("--start", help="exported network to begin a new run with, in place of --encoder")
parser.add_argument("--out", required=True, help="folder of checkpoint and log")
parser.add_argument("--batches", type=int, default=5000)
parser.add_argument("--decay", type=int, default=4000)
parser.add_argument("--batch", type=int, default=8)
parser.add_argument("--rate", type=float, default=1e-3, help="of the decoder")
parser.add_argument("--encoder-rate", type=float, default=1e-4)
parser.add_argument("--edges", type=float, default=0.5, help="weight of the edges' loss")
parser.add_argument("--photos", help="folder of masks.py: photos without depth")
parser.add_argument("--photo-share", type=int, default=2, help="photos that are added to each batch")
parser.add_argument("--photo-weight", type=float, default=0.5, help="weight of the photos' loss")
parser.add_argument("--sizes", type=int, nargs=2, metavar=("LEAST", "MOST"),
                    help="longer side of the batches, multiples of 32; fewer pictures in larger ones")
parser.add_argument("--teacher", help="exported network whose layout at 256 px the photos without depth shall have")
parser.add_argument("--teacher-weight", type=float, default=1)
parser.add_argument("--frozen", type=int, default=7, help="blocks of the encoder, 0..17")
parser.add_argument("--seed", type=int, default=1)
parser.add_argument("--only", type=int, default=0, help="train on the first frames only")
parser.add_argument("--evaluate", type=int, default=300, help="batches between evaluations")
parser.add_argument("--data", help="folder of the real test data, to validate with")
parser.add_argument("--bfloat16", action="store_true", help="twice as fast on some processors, less exact")
parser.add_argument("--threads", type=int, default=2)
if __name__ == "__main__":  # before what takes long to load or is missing
    args = parser.parse_args()

import numpy as np
import torch

from evaluate import real_scenes, scores_of, val_scenes
from frames import Batches
from loss import depth_loss, hiding_loss, layout_loss
from network import DepthNet, load_encoder, load_onnx, up

KEEP = 0.998  # of the averaged weights, per batch


def schedule(step, batches, decay):
    return min(1, (step + 1) / 100, max(0, batches - step) / max(1, decay))


def set_frozen(net, frozen):
    """Keeps the first convolution and the first `frozen` blocks of the encoder as they are."""
    for i, block in enumerate(net.encoder.blocks):
        block.requires_grad_(i >= frozen)
    net.encoder.first.requires_grad_(frozen == 0)


def balance(net, pictures):
    """Gives all that is added in the decoder, and its output, the same deviation to begin with."""
    def scale(layer, x, deviation):
        y = layer(x)
        mean = y.mean((0, 2, 3))
        factor = deviation / (y - y.mean((2, 3), keepdim=True)).std()
        layer.weight *= factor
        layer.bias.add_(-mean).mul_(factor)
        return layer(x)

    with torch.no_grad():
        features = net.encoder(pictures)
        y = net.refine[4](scale(net.lateral[4], features[4], 1))
        for level in (3, 2, 1, 0):
            above = up(scale(net.narrow[level], y, 0.7))
            y = net.refine[level](torch.relu(above + scale(net.lateral[level], features[level], 0.7)))
        scale(net.head, y, 1)


def teach(teacher, pictures, longer=256):
    """What the teacher predicts for the pictures at its best size, without preference for a side."""
    factor = longer / max(pictures.shape[2:])
    size = [max(32, 32 * round(side * factor / 32)) for side in pictures.shape[2:]]
    with torch.no_grad():
        small = torch.nn.functional.interpolate(pictures, size, mode="bilinear", antialias=True)
        both = teacher(torch.cat([small, small.flip(3)]))
        return (both[:len(pictures)] + both[len(pictures):].flip(3)) / 2


def save(file, **state):
    torch.save(state, file + ".part")
    os.replace(file + ".part", file)


def main():

    torch.set_num_threads(args.threads)
    torch.manual_seed(args.seed)
    np.random.seed(args.seed)
    random.seed(args.seed)
    os.makedirs(args.out, exist_ok=True)
    checkpoint = os.path.join(args.out, "checkpoint.pt")
    log = open(os.path.join(args.out, "log.csv"), "a", buffering=1)

    net, mean = DepthNet(), DepthNet()
    # the encoder's features have deviations of about 6, so steps of what they meet are smaller
    shares = {"encoder": args.encoder_rate / args.rate, "lateral": 0.2}
    optimizer = torch.optim.AdamW(
        [{"params": part.parameters(), "share": shares.get(name, 1)}
         for name, part in net.named_children()], weight_decay=1e-4)
    step = seen = 0
    state = None
    if os.path.exists(checkpoint):
        state = torch.load(checkpoint, map_location="cpu")
        net.load_state_dict(state["net"])
        mean.load_state_dict(state["mean"])
        optimizer.load_state_dict(state["optimizer"])
        step, seen = state["step"], state["seen"]
    elif args.start:
        try:
            load_onnx(net, args.start)
        except ValueError as error:
            sys.exit(f"train.py: {error}")
        mean.load_state_dict(net.state_dict())
    elif args.encoder:
        load_encoder(net.encoder, args.encoder)
    else:
        sys.exit(f"train.py: {checkpoint}: is missing, expected --encoder or --start for a new run")
    set_frozen(net, args.frozen)
    net = net.to(memory_format=torch.channels_last)
    mean = mean.to(memory_format=torch.channels_last)

    teacher = None
    if args.teacher:
        teacher = DepthNet()
        load_onnx(teacher, args.teacher)
        teacher = teacher.requires_grad_(False).to(memory_format=torch.channels_last)

    data = Batches(args.frames, args.sets, args.batch, args.seed, step, args.only,
                   args.photos, args.photo_share if args.photos else 0, args.sizes)
    loader = torch.utils.data.DataLoader(data, batch_size=None, num_workers=1, prefetch_factor=8)
    begin = last = time.time()
    seen_last = seen
    sums, photo_sums, count = np.zeros(4), np.zeros(3), 0
    for pictures, truth, maps in loader:
        pictures = pictures.contiguous(memory_format=torch.channels_last)
        if step == 0 and not args.start:
            balance(net, pictures)
            mean.load_state_dict(net.state_dict())
        share = schedule(step, args.batches, args.decay)
        for group in optimizer.param_groups:
            group["lr"] = args.rate * share * group["share"]
        with torch.autocast("cpu", torch.bfloat16, enabled=args.bfloat16):
            prediction = net(pictures)
            lesson = teach(teacher, pictures[len(truth):]).float() if teacher and maps is not None else None
        loss, error, order, edges = depth_loss(prediction[:len(truth)].float(), truth, args.edges)
        if maps is not None:
            hidden, slope = hiding_loss(prediction[len(truth):].float(), maps)
            loss = loss + args.photo_weight * (hidden + slope)
            layout = torch.zeros(())
            if teacher:
                layout = layout_loss(prediction[len(truth):].float(), lesson)
                loss = loss + args.teacher_weight * layout
            photo_sums += [hidden.item(), slope.item(), layout.item()]
        optimizer.zero_grad(set_to_none=True)
        loss.backward()
        torch.nn.utils.clip_grad_norm_(net.parameters(), 1.0)
        optimizer.step()
        step, seen = step + 1, seen + len(pictures)
        keep = min(KEEP, (step + 1) / (step + 10))
        with torch.no_grad():
            for own, other in zip(mean.parameters(), net.parameters()):
                own.lerp_(other, 1 - keep)
        sums += [loss.item(), error.item(), order.item(), edges.item()]
        count += 1
        done = step >= args.batches
        if step % 50 == 0 or done:
            now = time.time()
            print(f"{step} seen {seen} loss %.4f error %.4f order %.4f edges %.4f" % tuple(sums / count),
                  "photos %.4f %.4f %.4f" % tuple(photo_sums / count),
                  f"rate {share:.2f} {(seen - seen_last) / (now - last):.1f} pictures/s", flush=True)
            log.write(f"{step},{seen},train," + ",".join(f"{v:.4f}" for v in sums / count) + "\n")
            sums, photo_sums, count, last = sums * 0, photo_sums * 0, 0, now
            seen_last = seen
        if step % 100 == 0 or done:
            save(checkpoint, net=net.state_dict(), mean=mean.state_dict(),
                 optimizer=optimizer.state_dict(), step=step, seen=seen, args=vars(args))
        if step % args.evaluate == 0 or done:
            mean.eval()
            parts = ["%s %.3f %.3f" % (name, *scores_of(mean, scenes))
                     for name, scenes in {**val_scenes(args.frames, 40),
                                          **real_scenes(args.data, validation=True)}.items()]
            print(step, " ".join(parts), flush=True)
            log.write(f"{step},{seen},val," + ",".join(parts).replace(" ", ",") + "\n")
            last = time.time()
        if done:
            break
    print(f"{(time.time() - begin) / 3600:.2f} hours")


if __name__ == "__main__":
    main()
