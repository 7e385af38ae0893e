"""Sends where a webcam sees a face to altiro3Dview --show FILE --view-from udp:PORT.

face_to_udp.py [PORT] [CAMERA]
"""
import socket
import sys

import cv2

PORT = int(sys.argv[1]) if len(sys.argv) > 1 else 4242
CAMERA = sys.argv[2] if len(sys.argv) > 2 else "0"
CASCADES = [cv2.data.haarcascades] if hasattr(cv2, "data") else ["/usr/share/opencv4/haarcascades/"]
CONE = 0.7  # the part of the camera's picture that the view cone covers

finder = cv2.CascadeClassifier(CASCADES[0] + "haarcascade_frontalface_default.xml")
camera = cv2.VideoCapture(int(CAMERA) if CAMERA.isdigit() else CAMERA)
sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
smooth = None
while True:
    good, frame = camera.read()
    if not good:
        break
    grey = cv2.cvtColor(cv2.resize(frame, (320, 240)), cv2.COLOR_BGR2GRAY)
    faces = finder.detectMultiScale(grey, 1.1, 4, minSize=(40, 40))
    if len(faces) == 0:
        continue
    x, y, width, height = max(faces, key=lambda face: face[2])
    # the camera looks at the viewer: its left is the viewer's right
    place = [(0.5 - (x + width / 2) / 320) * 2 / CONE, (0.5 - (y + height / 2) / 240) * 2 / CONE]
    smooth = place if smooth is None else [0.6 * s + 0.4 * p for s, p in zip(smooth, place)]
    sender.sendto(b"%.3f %.3f\n" % tuple(smooth), ("127.0.0.1", PORT))
